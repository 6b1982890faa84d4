"""One bad input, and what came of it."""

from __future__ import annotations

import contextlib
import hashlib
import io
import os
import re
import tomllib
from dataclasses import dataclass
from pathlib import Path

from scenarios.cli import main

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
    wanted : str
        What the line must hold: the value, the place, or what is allowed.
    file : str
        The file that is wrong, if one is.
    text : str, optional
        All that it holds; else the good one is changed.
    old, new : str
        There the first match of a regular expression becomes another text.
    """

    title: str
    command: str
    wanted: str
    file: str = ""
    text: str | None = None
    old: str = ""
    new: str = ""

    def content(self, good: bytes) -> bytes:
        """Return what the wrong file holds."""
        if self.text is not None:
            return self.text.encode("latin-1")
        changed = re.sub(self.old, self.new, good.decode(), count=1, flags=re.MULTILINE)
        assert changed != good.decode(), f"{self.title}: nothing was changed"
        return changed.encode()


GROUPS = {
    group: [BadInputCase(title, **told) for title, told in cases.items()]
    for group, cases in tomllib.loads(
        Path(__file__).with_name("cases.toml").read_text("utf-8")
    ).items()
}
"""The bad inputs, by what is wrong."""


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
    wrong = {case.file: case.content(good.get(case.file, b""))} if case.file else {}
    for name, data in (good | wrong).items():
        (folder / name).write_bytes(data)
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
