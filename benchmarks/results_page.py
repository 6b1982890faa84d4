"""Writes measured tables into pages, between marks that name the command."""

from __future__ import annotations

import argparse
import re
from collections.abc import Iterable, Sequence
from pathlib import Path

from measurement.files import write_atomically

PAGE = Path(__file__).resolve().parents[1] / "docs" / "results.md"
BLOCK = re.compile(r"(<!-- begin (\w+): ([^\n]*) -->\n).*?(<!-- end \2 -->)", re.DOTALL)


def put(name: str, text: str, path: Path | None = None) -> None:
    """Write a command's table between its marks on docs/results.md or another page."""
    path = path or PAGE
    page = path.read_text(encoding="utf-8")
    if [found[1] for found in BLOCK.findall(page)].count(name) != 1:
        raise ValueError(f"{path}: needs one block {name}")

    def block(found: re.Match[str]) -> str:
        return f"{found[1]}\n{text.strip()}\n\n{found[4]}" if found[2] == name else found[0]

    write_atomically(path, BLOCK.sub(block, page))


def parser_of(doc: str, prog: str | None = None) -> argparse.ArgumentParser:
    """Return the parser of a benchmark that reports by `tell`; *doc* is its module's docstring."""
    parser = argparse.ArgumentParser(prog, description=doc.splitlines()[0])
    parser.add_argument("--write", action="store_true", help="also write it into docs")
    return parser


def tell(name: str, text: str, *, write: bool) -> None:
    """Print a command's table; with *write* also write it into docs/results.md."""
    print(text)
    if write:
        put(name, text)


def as_table(head: Sequence[str], rows: Iterable[Sequence[str]], *, flush: str = "---") -> str:
    """Return a Markdown table; *flush* is the alignment mark of all columns except the first."""
    lines = [head, ["---", *[flush] * (len(head) - 1)], *rows]
    return "\n".join(f"| {' | '.join(row)} |" for row in lines)
