"""Pages: a measured table stands between marks that name the command that makes it."""

from __future__ import annotations

import argparse
import re
from collections.abc import Iterable, Sequence
from pathlib import Path

from measurement.files import write_atomically

PAGE = Path(__file__).resolve().parents[1] / "docs" / "results.md"
BLOCK = re.compile(r"(<!-- begin (\w+): ([^\n]*) -->\n).*?(<!-- end \2 -->)", re.DOTALL)


def put(name: str, text: str, path: Path | None = None) -> None:
    """Put what a command has measured between its marks on docs/results.md, or another page."""
    path = path or PAGE
    page = path.read_text(encoding="utf-8")
    if [found[1] for found in BLOCK.findall(page)].count(name) != 1:
        raise ValueError(f"{path}: needs one block {name}")

    def block(found: re.Match[str]) -> str:
        return f"{found[1]}\n{text.strip()}\n\n{found[4]}" if found[2] == name else found[0]

    write_atomically(path, BLOCK.sub(block, page))


def parser_of(doc: str, prog: str | None = None) -> argparse.ArgumentParser:
    """Return the parser of a command that `tell` says the result of; *doc* is its module's."""
    parser = argparse.ArgumentParser(prog, description=doc.splitlines()[0])
    parser.add_argument("--write", action="store_true", help="also write it into docs")
    return parser


def tell(name: str, text: str, *, write: bool) -> None:
    """Print what a command has measured; with *write* also put it on docs/results.md."""
    print(text)
    if write:
        put(name, text)


def as_table(head: Sequence[str], rows: Iterable[Sequence[str]], *, flush: str = "---") -> str:
    """Return a Markdown table; *flush* are the marks under all heads but the first."""
    lines = [head, ["---", *[flush] * (len(head) - 1)], *rows]
    return "\n".join(f"| {' | '.join(row)} |" for row in lines)
