"""Writes the folder that LinuxCNC starts from: its files and its components' commands."""

from __future__ import annotations

import re
import shlex
from collections.abc import Mapping, Sequence
from pathlib import Path

from gateway import linuxcnc

CONFIG = Path(__file__).with_name("config")
SHIPPED = Path(linuxcnc.__file__).with_name("config")
"""HAL files that a real machine uses, too."""
WAYS = {"external": "external.hal", "own": "own.hal"}
"""The two ways to apply an offset, and the HAL file that each needs."""
NAME = "{name}"
"""Placeholder for the component's name in its command."""


def write_folder(folder: Path, way: str, commands: Mapping[str, Sequence[str]]) -> None:
    """Write the files of a simulated machine.

    Parameters
    ----------
    folder : Path
        The folder, which must exist.
    way : {"external", "own"}
        How offsets are applied.
    commands : mapping of str to sequence of str
        The commands that start ``thermal``, ``spindle`` and ``display``.
    """
    texts = {file.name: file.read_text() for place in (CONFIG, SHIPPED) for file in place.iterdir()}
    for name in ("machine.ini", "tool.tbl", "thermal.hal"):
        (folder / name).write_text(texts[name])
    parts = ["machine.hal", WAYS[way], "guard.hal", "spindle.hal", "thermal.hal"]
    (folder / "machine.hal").write_text("\n".join(texts[part] for part in parts))
    for name, command in commands.items():
        script = folder / f"{name}.sh"
        words = " ".join('"$1"' if word == NAME else shlex.quote(word) for word in command)
        script.write_text(f"#!/bin/sh\nexec {words}\n")
        script.chmod(0o755)


def renamed(folder: Path, name: str) -> Path:
    """Write the HAL file that connects the component under another name; return it."""
    text = (folder / "thermal.hal").read_text()
    loaded = "loadusr -Wn {0} ./thermal.sh {0}\n"
    text = text.replace(loaded.format("thermal"), loaded.format(name))
    file = folder / f"{name}.hal"
    file.write_text(re.sub(r"\bthermal\.(?!sh)", f"{name}.", text))
    return file
