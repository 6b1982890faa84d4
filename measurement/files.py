"""Reads files, writes them whole or not at all, and computes their fingerprints."""

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
from measurement.locks import lock

FULL = frozenset(
    number
    for name in ("ENOSPC", "EDQUOT", "EFBIG", "EROFS")
    if (number := getattr(errno, name, None)) is not None
)
"""System errors that mean that there is no space, or no permission, to write."""


def write_atomically(path: str | Path, data: str | bytes) -> Path:
    """Write *data* to *path* so that no reader ever sees half of it.

    The data goes to a temporary file in the same folder, which is then renamed to the target in one
    step. Data and name are on the disk when this returns, so that a power cut does not bring back
    the old file. Missing folders are created. A link is followed and stays a link.

    Parameters
    ----------
    path : str or Path
        The target.
    data : str or bytes
        Text is written as UTF-8 with its line ends unchanged.

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

    Files are renamed only when the data of all are on the disk, so a full disk changes nothing.

    Parameters
    ----------
    files : mapping of Path to str or bytes
        The files, in the order in which they are renamed.

    Raises
    ------
    BadInput
        For the first file that cannot be written, or is a folder or a device.
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


@contextlib.contextmanager
def holding(folder: Path) -> Iterator[None]:
    """Let one process at a time read and then rewrite files of a folder.

    Parameters
    ----------
    folder : Path
        Created if missing.

    Raises
    ------
    BadInput
        If it cannot be created or read.
    """
    with contextlib.ExitStack() as stack:
        with _refusing(folder):
            folder.mkdir(parents=True, exist_ok=True)
            if hasattr(os, "O_DIRECTORY"):  # Windows: a folder cannot be opened
                handle = os.open(folder, os.O_RDONLY)
                stack.callback(os.close, handle)
                lock(handle)
        yield


def check_writable(path: Path, file: Path) -> None:
    """Check before long work that its result file can be written.

    Parameters
    ----------
    path : Path
        Path that the refusal names.
    file : Path
        The file; neither it nor its folder need exist.

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
    """Flush the names in a folder to the disk, if the platform supports it."""
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
        An ordinary file, or a pipe made by the shell.

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
    except BadInput:
        raise
    except (OSError, ValueError) as error:  # ValueError: a null byte in the name
        raise BadInput(path, "", f"cannot be read: {_reason(error)}") from None


def read_toml(path: str | Path) -> dict[str, Any]:
    """Return the table in a TOML file.

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
    """Return the table in the content of a TOML file.

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
    """Refuse a path that could be read without end: a named pipe or a device.

    The shell's own pipes, such as ``<(zcat run.csv.gz)``, end and are accepted.

    Parameters
    ----------
    path : Path
        Need not exist.

    Raises
    ------
    BadInput
        If the path is such a pipe or device.
    """
    # The shell's pipes have no name in any folder: the target of /dev/fd/63 does not exist.
    if path.is_char_device() or (path.is_fifo() and path.resolve().is_fifo()):
        raise BadInput(path, "", "is a pipe or a device; an ordinary file is needed")


def json_ready(value: Any, digits: int | None = None) -> Any:
    """Return a value that JSON can hold: numbers that are not finite become null.

    Parameters
    ----------
    value : object
        Dicts, lists, numbers and texts.
    digits : int, optional
        Decimal places to which numbers are rounded.
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
