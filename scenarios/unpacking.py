"""FMUs unpacked into temporary folders, which go when nobody uses them any more.

A process that is killed removes nothing. So the folder holds a file that its process keeps locked,
and whoever unpacks next removes the folders whose lock nobody holds. Locks are a kernel's own: a
guest and its host that share a temporary folder do not see each other's. So folders carry the
kernel's name, and only those of the running one are looked at.
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

from measurement.errors import BadInput

try:
    import fcntl
except ImportError:  # elsewhere than on Linux and macOS nothing is locked, and nothing swept
    fcntl = None  # type: ignore[assignment]

PREFIX = "spindle-drift-fmu-"
LOCK = "in_use.lock"
BOOT_ID = Path("/proc/sys/kernel/random/boot_id")


def prefix() -> str:
    """Return how the folders of the running kernel begin."""
    try:
        return f"{PREFIX}{BOOT_ID.read_text()[:8]}-"
    except OSError:  # elsewhere than on Linux: the machine's name must do
        plain = "".join(c for c in platform.node() if c.isascii() and c.isalnum())
        return f"{PREFIX}{plain[:32]}-"


class Unpacked:
    """An FMU in a folder of its own, whose name every FMU can read from a URI.

    Parameters
    ----------
    path : Path
        The ``.fmu`` file.

    Attributes
    ----------
    folder : Path

    Raises
    ------
    BadInput
        If the temporary folder has a name that FMUs cannot read, or the file cannot be unpacked.
    """

    def __init__(self, path: Path) -> None:
        place = Path(tempfile.gettempdir())
        plain = place.as_posix().replace(" ", "")
        if urllib.parse.quote(plain) != plain:
            problem = "is not fit for unpacking FMUs: set TMPDIR to a folder whose path is plain"
            raise BadInput(place, "", f"{problem} ASCII")
        sweep(place)
        self._lock: int | None = None
        self.folder = Path(tempfile.mkdtemp(prefix=prefix()))
        try:
            self._lock = _locked(self.folder)
            fmpy.extract(str(path), unzipdir=str(self.folder))
        except BaseException as error:
            self.remove()
            if not isinstance(error, Exception):
                raise
            problem = " ".join(str(error).split())
            raise BadInput(path, "", f"cannot be unpacked into {place}: {problem}") from None

    def remove(self) -> None:
        """Remove the folder; a second time does nothing."""
        shutil.rmtree(self.folder, ignore_errors=True)
        if self._lock is not None:
            os.close(self._lock)
            self._lock = None


def sweep(place: Path) -> None:
    """Remove the folders in *place* whose processes have gone without removing them."""
    if fcntl is None:
        return
    for lock in place.glob(f"{prefix()}*/{LOCK}"):
        # A folder of another user, or one that somebody else removes at the same time.
        with contextlib.suppress(OSError):
            handle = os.open(lock, os.O_RDWR)
            try:
                fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
                shutil.rmtree(lock.parent, ignore_errors=True)
            finally:
                os.close(handle)


def _locked(folder: Path) -> int | None:
    """Lock a file in *folder*; it takes its name only then, so no sweep ever sees it unlocked."""
    if fcntl is None:
        return None
    handle, name = tempfile.mkstemp(dir=folder)
    fcntl.flock(handle, fcntl.LOCK_EX)
    Path(name).rename(folder / LOCK)
    return handle
