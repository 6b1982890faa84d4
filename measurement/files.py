"""Files written whole or not at all, and their fingerprints."""

from __future__ import annotations

import contextlib
import errno
import hashlib
import math
import os
import secrets
import tempfile
import tomllib
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from measurement.errors import BadInput

FULL = frozenset(
    number
    for name in ("ENOSPC", "EDQUOT", "EFBIG", "EROFS")
    if (number := getattr(errno, name, None)) is not None
)
"""Errors of the system that say that there is no room to write, or no leave."""


def write_atomically(path: str | Path, data: str | bytes) -> Path:
    """Write *data* to *path* so that no reader ever sees half of it.

    The data goes to a temporary file in the same folder, which then takes the target's name in one
    step. Data and name are on the disk when this returns, so that a power cut does not bring back
    the file of before. Folders that are missing are made. A link is followed, so that it stays one.

    Parameters
    ----------
    path : str or Path
        The target.
    data : str or bytes
        What to write; text is written as UTF-8 with its line ends unchanged.

    Returns
    -------
    Path
        The path given.

    Raises
    ------
    BadInput
        If the target cannot be written, or is a folder or a device.
    """
    path = Path(path)
    write_together({path: data})
    return path


def write_together(files: Mapping[Path, str | bytes]) -> None:
    """Write files that belong together, each as `write_atomically` does.

    None takes its name before the data of all are on the disk, so a full disk changes nothing.

    Parameters
    ----------
    files : mapping of Path to str or bytes
        What to write; the last one takes its name last.

    Raises
    ------
    BadInput
        For the first that cannot be written, or is a folder or a device.
    """
    written: list[tuple[Path, Path, Path]] = []
    try:
        for path, data in files.items():
            target = path.resolve()
            _refuse_extraordinary(path, target)
            # A short name: the target's may already be as long as the file system allows.
            temporary = target.parent / f".{secrets.token_hex(8)}.tmp"
            written.append((path, temporary, target))
            with _refusing(path):
                _write(temporary, data)
        for path, temporary, target in written:
            with _refusing(path):
                temporary.replace(target)
    except BaseException:
        for _, temporary, _ in written:
            with contextlib.suppress(OSError):
                temporary.unlink()
        raise
    for folder in {target.parent for _, _, target in written}:
        _sync_names(folder)


def check_writable(path: Path, file: Path) -> None:
    """Check before the work that a file can be written when it is done.

    Parameters
    ----------
    path : Path
        What the refusal names.
    file : Path
        Neither it nor its folder need exist.

    Raises
    ------
    BadInput
        As `write_atomically` would.
    """
    target = file.resolve()
    _refuse_extraordinary(path, target)
    folder = next(each for each in target.parents if each.exists())
    with _refusing(path), tempfile.TemporaryFile(dir=folder):
        pass


def _refuse_extraordinary(path: Path, target: Path) -> None:
    if target.exists() and not target.is_file():
        # Replacing a device such as /dev/null by a file would be a disaster.
        raise BadInput(path, "", "cannot be written: it exists and is not an ordinary file")


@contextlib.contextmanager
def _refusing(path: Path) -> Iterator[None]:
    try:
        yield
    except OSError as error:
        raise BadInput(path, "", f"cannot be written: {error.strerror or error}") from None


def _write(path: Path, data: str | bytes) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    with path.open("xb") as stream:
        stream.write(data.encode("utf-8") if isinstance(data, str) else data)
        stream.flush()
        os.fsync(stream.fileno())


def _sync_names(folder: Path) -> None:
    """Bring the names in a folder to the disk, where the platform can."""
    if not hasattr(os, "O_DIRECTORY"):  # Windows: a folder cannot be opened
        return
    # Some network file systems refuse; the file itself is written by then.
    with contextlib.suppress(OSError):
        handle = os.open(folder, os.O_RDONLY | os.O_DIRECTORY)
        try:
            os.fsync(handle)
        finally:
            os.close(handle)


def read_bytes(path: str | Path) -> bytes:
    """Return the content of a file.

    Parameters
    ----------
    path : str or path
        An ordinary file, or a pipe that the shell made.

    Raises
    ------
    BadInput
        If it is missing, a folder, or cannot be read.
    """
    path = Path(path)
    try:
        if path.is_dir():
            raise BadInput(path, "", "is a folder; a file is needed")
        refuse_endless(path)
        return path.read_bytes()
    except FileNotFoundError:
        raise BadInput(path, "", "no such file") from None
    except (OSError, ValueError) as error:  # ValueError: a null byte in the name
        raise BadInput(path, "", f"cannot be read: {_reason(error)}") from None


def read_toml(path: str | Path) -> dict[str, Any]:
    """Return the table that a TOML file holds.

    Parameters
    ----------
    path : str or path

    Raises
    ------
    BadInput
        As `read_bytes`, and if it is not TOML.
    """
    return toml_table(read_bytes(path), path)


def toml_table(content: str | bytes, source: str | Path) -> dict[str, Any]:
    """Return the table that a TOML file's content holds.

    Parameters
    ----------
    content : str or bytes
    source : str or path
        The file, for the refusal.

    Raises
    ------
    BadInput
        If it is not TOML.
    """
    try:
        return tomllib.loads(content if isinstance(content, str) else content.decode("utf-8"))
    except (ValueError, RecursionError) as error:  # of UTF-8, of TOML, of nesting
        raise BadInput(source, "", f"is not TOML: {error}") from None


def refuse_endless(path: Path) -> None:
    """Refuse what reading would never end: a pipe in a folder, or a device.

    The shell's own pipes, such as ``<(zcat run.csv.gz)``, have an end and are read.

    Parameters
    ----------
    path : Path
        Need not exist.

    Raises
    ------
    BadInput
        For such a path.
    """
    # The shell's pipes have no name in any folder: what /dev/fd/63 links to does not exist.
    if path.is_char_device() or (path.is_fifo() and path.resolve().is_fifo()):
        raise BadInput(path, "", "is a pipe or a device; an ordinary file is needed")


def json_ready(value: Any, digits: int | None = None) -> Any:
    """Return a value as JSON carries it: what is not finite as null.

    Parameters
    ----------
    value : object
        Dicts, lists, numbers and texts.
    digits : int, optional
        To which numbers are rounded.
    """
    if isinstance(value, dict):
        return {key: json_ready(entry, digits) for key, entry in value.items()}
    if isinstance(value, list | tuple):
        return [json_ready(entry, digits) for entry in value]
    if not isinstance(value, float):
        return value
    if not math.isfinite(value):
        return None
    return value if digits is None else float(f"{value:.{digits}g}")


def sha256_of(path: str | Path) -> str:
    """Return the SHA-256 of a file's bytes, in hexadecimal.

    Parameters
    ----------
    path : str or path

    Raises
    ------
    BadInput
        If the file is missing, a folder, or cannot be read.
    """
    return hashlib.sha256(read_bytes(path)).hexdigest()


def _reason(error: Exception) -> str:
    return (error.strerror if isinstance(error, OSError) else None) or str(error)
