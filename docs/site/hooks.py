"""What the site adds to the pages: the files at the top, the reference made from the code.

The pages are written to be read in the repository, too. So links that leave the folder are pointed
at the pages that stand for their targets here, and the words after a fence become the title of the
block.
"""

from __future__ import annotations

import argparse
import html
import re
import tempfile
from pathlib import Path
from typing import Any

from mkdocs.config.defaults import MkDocsConfig
from mkdocs.structure.files import File, Files

from plant_model.machine_file import read_machine
from scenarios import cli
from scenarios.building import DEFAULT_MACHINE, DEFAULT_MODEL
from scenarios.pages.web_page import write_web_page
from scenarios.version import PROGRAM

ROOT = Path(__file__).parents[2]
TOP = {
    "README.md": "index.md",
    "CONTRIBUTING.md": "contributing.md",
    "CHANGELOG.md": "changelog.md",
}
"""Pages at the top of the repository, and what they are called here."""
BESIDE = {"LICENSE": "LICENSE.txt", "gateway/spindle_drift.dbc": "spindle_drift.dbc"}
"""Other files that pages link to."""
LIVE = "spindle.html"
PYTHON = "api.md"
"""The page that the reference of the library follows."""
LIVE_PICTURE = re.compile(r"!\[[^\]]*\]\([^)\s]*figures/web_page\.png\)")
"""The picture of the live page; here it opens the page itself."""
LINK = re.compile(r"(!?\[[^\]]*\]\()([^)\s#]+)(#[^)\s]*)?(\))")
BLOCK = re.compile(r"(^```.*?^```[ \t]*$)", re.MULTILINE | re.DOTALL)
NESTED = re.compile(r"^ {2,3}(?=[-*] )", re.MULTILINE)
"""A list in a list as the repository shows it; Markdown for the site asks for four blanks."""
FENCE = re.compile(r"^(`{3,})(\w+)[ \t]+([^\n`]+)$", re.MULTILINE)


def on_files(files: Files, config: MkDocsConfig) -> Files:
    """Add the pages and files that are not in the folder."""
    for source, name in {**TOP, **BESIDE}.items():
        path = ROOT / source
        content = path.read_text(encoding="utf-8")
        files.append(File.generated(config, name, content=content))
    files.append(File.generated(config, LIVE, content=live_page()))
    files.append(File.generated(config, "reference/commands.md", content=commands_page()))
    return files


def on_page_markdown(markdown: str, page: Any, **_: Any) -> str:
    """Point links at this site's pages, and give blocks titles."""
    place = page.file.src_uri
    source = next((top for top, name in TOP.items() if name == place), f"docs/{place}")
    if not place.startswith(("reference/", "notebooks/")):
        markdown = LINK.sub(lambda found: _link(found, source, place), markdown)
        markdown = LIVE_PICTURE.sub(rf"[\g<0>]({LIVE})\n\n[Open it]({LIVE}).", markdown)
    parts = BLOCK.split(markdown)
    parts[::2] = [NESTED.sub("    ", text) for text in parts[::2]]
    markdown = FENCE.sub(_titled, "".join(parts))
    return f"{markdown}\n\n{python_names()}" if place == PYTHON else markdown


def _link(found: re.Match[str], source: str, place: str) -> str:
    head, target, anchor, tail = found.groups()
    if "://" in target:
        return found[0]
    path = (ROOT / source).parent / target
    try:
        inside = path.resolve().relative_to(ROOT).as_posix()
    except ValueError:
        return found[0]
    known = {**TOP, **BESIDE}.get(inside, inside.removeprefix("docs/"))
    up = "../" * place.count("/")
    return f"{head}{up}{known}{anchor or ''}{tail}"


def _titled(found: re.Match[str]) -> str:
    fence, language, words = found.groups()
    return f'{fence}{language} title="{words.strip()}"'


def live_page() -> str:
    """Return the shipped machine and compensator as a live page."""
    with tempfile.TemporaryDirectory() as work:
        path = Path(work) / LIVE
        write_web_page(read_machine(DEFAULT_MACHINE), DEFAULT_MODEL, path)
        return path.read_text(encoding="utf-8")


def commands_page() -> str:
    """Return the page of all commands, from their parsers."""
    lines = [
        "# Commands",
        "",
        f"`{PROGRAM} COMMAND`. Exit codes: 0; 2 for input that cannot be used, with one line;",
        "1 for an FMU that failed or a mistake in this program; 130 when interrupted; 143 when",
        "terminated.",
        "",
    ]
    for name, (_, text) in sorted(cli.commands().items()):
        command = cli.parser_of(name)
        lines += [f"## {name}", "", f"{text[0].upper()}{text[1:]}.", ""]
        lines += ["```text", command.format_usage().strip(), "```", ""]
        lines += ["| Argument | What it says |", "| --- | --- |"]
        for action in command._actions:
            if not isinstance(action, argparse._HelpAction):
                lines.append(f"| {_argument(action)} | {_cell(action.help or '')} |")
        lines.append("")
    return "\n".join(lines) + "\n"


def _argument(action: argparse.Action) -> str:
    value = action.metavar or (action.dest.upper() if action.nargs != 0 else "")
    shown = " ".join(value) if isinstance(value, tuple) else str(value)
    names = ", ".join(action.option_strings)
    # Marks of code would show the backslash before a bar.
    text = html.escape(" ".join(f"{names} {shown}".split())).replace("|", "&#124;")
    return f"<code>{text}</code>"


def _cell(text: str) -> str:
    return " ".join(text.split()).replace("%%", "%").replace("|", "\\|")


def python_names() -> str:
    """Return what makes the reference of the public names, for the end of their page."""
    import spindle_drift

    names = sorted(spindle_drift.__all__, key=str.lower)
    return "\n\n".join(f"::: spindle_drift.{name}" for name in names) + "\n"
