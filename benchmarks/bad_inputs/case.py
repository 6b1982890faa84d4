"""One bad input, and what came of it."""

from __future__ import annotations

import contextlib
import hashlib
import io
import os
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

from scenarios.cli import main

Change = Callable[[str], str]
LONGEST_LINE = 1000


@dataclass(frozen=True)
class BadInputCase:
    """A bad input.

    Attributes
    ----------
    title : str
        What is wrong.
    command : str
        The words after ``spindle-drift``; files are those of the folder, ``{dist}`` the folder of
        FMUs.
    files : dict of str to str or bytes
        Files to write first, over good ones where these have the name.
    changes : dict of str to callable
        What is done to the text of good files.
    wanted : str
        What the line must hold: the value, the place, or what is allowed.
    """

    title: str
    command: str
    wanted: str
    files: dict[str, str | bytes] = field(default_factory=dict)
    changes: dict[str, Change] = field(default_factory=dict)


@dataclass(frozen=True)
class Answer:
    """What a command said.

    Attributes
    ----------
    case : BadInputCase
    code : int
        Exit code.
    line : str
        Standard error.
    lost : list of str
        Files that were there before and are not the same.
    left : list of str
        Files and folders that are new.
    """

    case: BadInputCase
    code: int
    line: str
    lost: list[str]
    left: list[str]

    @property
    def problem(self) -> str:
        """What is not as promised; nothing where all is."""
        if self.code != 2:
            return f"exit code {self.code}: {self.line[-200:]}"
        if self.line.count("\n") != 1 or len(self.line) > LONGEST_LINE:
            return f"not one line: {self.line[:300]}"
        if self.case.wanted not in self.line:
            return f"{self.case.wanted!r} is not in: {self.line}"
        if self.lost or self.left:
            return f"lost {self.lost}, left {self.left}"
        return ""


def ask(case: BadInputCase, good: dict[str, bytes], folder: Path, dist: Path) -> Answer:
    """Run a case in an empty folder with the good files.

    Parameters
    ----------
    case : BadInputCase
    good : dict of str to bytes
        Files by name.
    folder : Path
    dist : Path
        Where built FMUs are.
    """
    for name, data in good.items():
        (folder / name).write_bytes(data)
    for name, content in case.files.items():
        data = content.encode() if isinstance(content, str) else content
        (folder / name).write_bytes(data)
    for name, change in case.changes.items():
        old = (folder / name).read_text(encoding="utf-8")
        new = change(old)
        assert new != old, f"{case.title}: nothing was changed in {name}"
        (folder / name).write_text(new, encoding="utf-8")
    before = _fingerprints(folder)
    said = io.StringIO()
    here = Path.cwd()
    os.chdir(folder)
    try:
        with contextlib.redirect_stderr(said), contextlib.redirect_stdout(io.StringIO()):
            code = main(case.command.format(dist=dist).split())
    finally:
        os.chdir(here)
    after = _fingerprints(folder)
    lost = [name for name in before if after.get(name) != before[name]]
    left = [name for name in after if name not in before]
    return Answer(case, code, said.getvalue(), lost, left)


def _fingerprints(folder: Path) -> dict[str, str]:
    return {
        path.relative_to(folder).as_posix(): hashlib.sha256(path.read_bytes()).hexdigest()
        if path.is_file()
        else "folder"
        for path in sorted(folder.rglob("*"))
    }


def replaced(old: str, new: str) -> Change:
    """Return what puts *new* in place of the first *old*."""
    return lambda text: text.replace(old, new, 1)


def cell(row: int, column: str, value: str) -> Change:
    """Return what puts a value into a cell of a CSV file; row 1 is the header."""

    def change(text: str) -> str:
        lines = text.splitlines()
        place = lines[0].split(",").index(column)
        words = lines[row - 1].split(",")
        words[place] = value
        lines[row - 1] = ",".join(words)
        return "\n".join(lines) + "\n"

    return change


def without_column(column: str) -> Change:
    """Return what takes a column out of a CSV file."""

    def change(text: str) -> str:
        rows = [line.split(",") for line in text.splitlines()]
        place = rows[0].index(column)
        return "\n".join(",".join(row[:place] + row[place + 1 :]) for row in rows) + "\n"

    return change
