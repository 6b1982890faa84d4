"""Writes the folder that LinuxCNC starts from: its files and its components' commands."""

from __future__ import annotations

import re
import shlex
from collections.abc import Mapping, Sequence
from pathlib import Path

CONFIG = Path(__file__).with_name("config")
WAYS = {"external": "external.hal", "own": "own.hal"}
"""The two ways to apply an offset, and the HAL file that each needs."""
NAME = "{name}"
"""Placeholder for the component's name in its command."""


def write_folder(folder: Path, way: str, commands: Mapping[str, Sequence[str]]) -> Path:
    """Write the files of a simulated machine; return its INI file.

    Parameters
    ----------
    folder : Path
        The folder, which must exist.
    way : {"external", "own"}
        How offsets are applied.
    commands : mapping of str to sequence of str
        The commands that start ``thermal``, ``spindle`` and ``display``.
    """
    for name in ("tool.tbl", "thermal.hal"):
        (folder / name).write_text((CONFIG / name).read_text())
    ini = folder / "machine.ini"
    ini.write_text((CONFIG / ini.name).read_text())
    parts = ["machine.hal", WAYS[way], "guard.hal", "spindle.hal", "thermal.hal"]
    (folder / "machine.hal").write_text("\n".join((CONFIG / part).read_text() for part in parts))
    for name, command in commands.items():
        script = folder / f"{name}.sh"
        words = " ".join('"$1"' if word == NAME else shlex.quote(word) for word in command)
        script.write_text(f"#!/bin/sh\nexec {words}\n")
        script.chmod(0o755)
    return ini


def renamed(folder: Path, name: str) -> Path:
    """Write the HAL file that connects the component under another name; return it."""
    text = (folder / "thermal.hal").read_text()
    loaded = "loadusr -Wn {0} ./thermal.sh {0}\n"
    text = text.replace(loaded.format("thermal"), loaded.format(name))
    file = folder / f"{name}.hal"
    file.write_text(re.sub(r"\bthermal\.(?!sh)", f"{name}.", text))
    return file
