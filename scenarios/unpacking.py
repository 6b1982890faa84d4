"""Unpacks FMUs into temporary folders, which are removed when no longer used.

A killed process removes nothing. So the folder contains a file that its process keeps locked, and
the next process that unpacks removes the folders whose lock is free. Locks belong to a kernel: a
guest and a host that share a temporary folder do not see each other's. So the folders' names
contain the kernel's, and only those of the running kernel are checked.
"""

from __future__ import annotations

import contextlib
import os
import platform
import shutil
import tempfile
import urllib.parse
from pathlib import Path

import fmpy

from measurement.errors import BadInput, one_line
from measurement.locks import lock

PREFIX = "spindle-drift-fmu-"
LOCK = "in_use.lock"
BOOT_ID = Path("/proc/sys/kernel/random/boot_id")


def prefix() -> str:
    """Return the name prefix of the running kernel's folders."""
    try:
        return f"{PREFIX}{BOOT_ID.read_text()[:8]}-"
    except OSError:  # not on Linux: use the computer's name
        plain = "".join(c for c in platform.node() if c.isascii() and c.isalnum())
        return f"{PREFIX}{plain[:32]}-"


def place_in_python() -> Path:
    """Return the temporary folder for unpacking FMUs in Python.

    Raises
    ------
    BadInput
        If they cannot read its name from a URI.
    """
    place = Path(tempfile.gettempdir())
    plain = place.as_posix().replace(" ", "")
    if urllib.parse.quote(plain) != plain:
        problem = (
            "is not fit for unpacking an FMU in Python: set TMPDIR to a folder whose path is "
            "plain ASCII, or use FMUs in C (build_fmu.py --native)"
        )
        raise BadInput(place, "", problem)
    return place


class Unpacked:
    """An FMU in its own folder.

    Parameters
    ----------
    path : Path
        The ``.fmu`` file.
    in_python : bool
        Whether it is an FMU in Python, which cannot read every folder's name from a URI.

    Attributes
    ----------
    folder : Path

    Raises
    ------
    BadInput
        If it cannot read the temporary folder's name, or the file cannot be unpacked.
    """

    def __init__(self, path: Path, *, in_python: bool = True) -> None:
        place = place_in_python() if in_python else Path(tempfile.gettempdir())
        sweep(place)
        self._lock: int | None = None
        self.folder = Path(tempfile.mkdtemp(prefix=prefix()))
        try:
            self._lock, name = tempfile.mkstemp(dir=self.folder)
            if lock(self._lock):  # renamed only then, so no sweep ever sees it unlocked
                Path(name).rename(self.folder / LOCK)
            fmpy.extract(str(path), unzipdir=str(self.folder))
        except BaseException as error:
            self.remove()
            if not isinstance(error, Exception):
                raise
            problem = f"cannot be unpacked into {place}: {one_line(error)}"
            raise BadInput(path, "", problem) from None

    def remove(self) -> None:
        """Remove the folder; a second call does nothing."""
        if self._lock is not None:
            os.close(self._lock)
            self._lock = None
        shutil.rmtree(self.folder, ignore_errors=True)


def sweep(place: Path) -> None:
    """Remove the folders in *place* whose processes ended without removing them."""
    for path in place.glob(f"{prefix()}*/{LOCK}"):
        # A folder of another user, or one that another process removes at the same time.
        with contextlib.suppress(OSError), path.open("r+b") as file:
            if lock(file.fileno(), wait=False):
                shutil.rmtree(path.parent, ignore_errors=True)
