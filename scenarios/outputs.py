"""What a command may overwrite: the one place that knows its inputs and outputs.

A command declares both as constants: ``READS``, the arguments that name files it reads, and
``WRITES``, the arguments that name what it writes, and of which kind. The command line checks them
before the command does any work. A file is replaced if its content shows that the same command made
it, and never if the command also reads it. No folder is created except the results folder that the
user names. ``--force`` lifts all of this; even then, files with other names in a results folder
stay.
"""

from __future__ import annotations

import argparse
import contextlib
import hashlib
import json
import os
import zipfile
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextvars import ContextVar
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

from measurement.errors import BadInput
from measurement.files import check_writable, refuse_endless

TABLE = "table.json"
RESULTS = "spindle-drift results"
FOLDER, FOLDER_THAT_GOES_ON = "folder of results", "folder that goes on"
FOLDER_OF_RUNS = "folder of runs"
"""Other files in it stay; the writer checks each file that is in the way."""
FOLDERS = (FOLDER, FOLDER_THAT_GOES_ON, FOLDER_OF_RUNS)
OF_FILES = (".csv", ".html", ".json", ".png", ".toml")
"""Extensions of files that commands write into folders; no new folder may have one."""
OTHERWISE = "choose another name, or let --force replace it"
MADE = "# made by spindle-drift; SHA-256 of what follows: "
"""First line of a machine file that a command wrote."""


@dataclass(frozen=True)
class Guard:
    """What the running command reads, and whether it may overwrite anything."""

    command: str = ""
    inputs: tuple[Path, ...] = ()
    force: bool = False


_NOTHING = Guard()
_GUARD: ContextVar[Guard] = ContextVar("guard", default=_NOTHING)


@contextlib.contextmanager
def guarding(
    command: str, inputs: Sequence[str | Path] = (), force: bool = False
) -> Iterator[None]:
    """Protect the inputs of a command, and other files, while the block runs.

    Calls within the block use this guard, even if they would set their own.

    Parameters
    ----------
    command : str
        Its name: only its own results are replaced.
    inputs : sequence of str or Path
        What it reads; names that are not files are ignored.
    force : bool
        Whether anything may be replaced.

    Yields
    ------
    None
    """
    if _GUARD.get() is not _NOTHING:
        yield
        return
    files = tuple(path for path in map(Path, inputs) if _is_there(path))
    for path in files:
        refuse_endless(path)
    token = _GUARD.set(Guard(command, files, force))
    try:
        yield
    finally:
        _GUARD.reset(token)


@contextlib.contextmanager
def guarding_command(
    command: str, args: argparse.Namespace, reads: Sequence[str], writes: Mapping[str, str]
) -> Iterator[None]:
    """Check a command line's outputs, and keep its inputs protected while the block runs.

    Parameters
    ----------
    command : str
    args : Namespace
        Parsed arguments, with ``force``.
    reads, writes
        The command's ``READS`` and ``WRITES``.

    Raises
    ------
    BadInput
        For the first output that may not be written.
    """
    named = [text for name in reads for text in _texts(getattr(args, name))]
    with guarding(command, named, args.force):
        given = {name: getattr(args, name) for name in writes if getattr(args, name) is not None}
        for name, path in given.items():
            check_output(Path(path), writes[name])
        yield


def also_reads(paths: Sequence[Path]) -> None:
    """Protect further inputs of the running command, which one of its files names.

    Parameters
    ----------
    paths : sequence of Path
        Paths that are not files are ignored.
    """
    guard = _GUARD.get()
    more = tuple(path for path in paths if _is_there(path))
    _GUARD.set(replace(guard, inputs=guard.inputs + more))


def _texts(value: object) -> list[str]:
    """Return the possible paths in an argument's value, including the path of ``name=path``."""
    if value is None:
        return []
    several = value if isinstance(value, list) else [value]
    texts = [str(item) for item in several]
    return texts + [text.partition("=")[2] for text in texts if "=" in text]


def check_output(path: Path, kind: str) -> None:
    """Check that something of a *kind* may be written to *path*.

    Parameters
    ----------
    path : Path
        Need not exist.
    kind : str
        One of the kinds that this module names, such as `FOLDER`.

    Raises
    ------
    BadInput
        If it may not; the line says why, and what to do instead.
    """
    try:
        is_new = kind in FOLDERS and not path.exists()
        if is_new and path.suffix.lower() in OF_FILES and not is_forced():
            plain = path.with_suffix("")
            raise BadInput(path, "", f"is called as a file; a {kind} is needed, such as {plain}")
        if kind == FOLDER:
            check_folder(path)
        elif kind == FOLDER_THAT_GOES_ON:
            _check_no_input_inside(path)
        elif kind == FOLDER_OF_RUNS:
            if path.exists() and not path.is_dir() and not is_forced():
                raise BadInput(path, "", "is a file; a folder for the run files is needed")
        else:
            _check_file(path, kind)
        # A results folder is written next to the one that it replaces; others grow in place.
        grows = kind != FOLDER and not path.is_file()
        beside = (path if grows else path.resolve().parent) / TABLE
        # With --force a gateway continues without its log and its state.
        if not (is_forced() and kind in (LOG, STATE)):
            check_writable(path, beside if kind in FOLDERS else path)
    except OSError as error:
        raise BadInput(path, "", f"cannot be used: {error.strerror}") from None


def _check_file(path: Path, kind: str) -> None:
    guard = _GUARD.get()
    if guard.force or path.is_dir():
        return  # the writer refuses to write to a folder
    if is_input(path) and kind != STATE:
        raise BadInput(path, "", f"is an input of this command: {OTHERWISE}")
    if path.is_file():
        if not KINDS[kind](path):
            why = f"and is no {kind} that this program made"
            why = "and may be a measurement" if KINDS[kind] is _never else why
            raise BadInput(path, "", f"exists {why}: {OTHERWISE}")
    elif not path.resolve().parent.is_dir():
        problem = "does not exist: make it first, or let --force make it"
        raise BadInput(path, "", f"the folder {path.parent} {problem}")


def check_folder(folder: Path) -> None:
    """Check that results may go to *folder*: a new or empty folder, or a results folder.

    Raises
    ------
    BadInput
        If it is a file, or a folder that contains other files or an input.
    """
    try:
        if not folder.exists():
            return
        if not folder.is_dir():
            raise BadInput(folder, "", "is a file; a folder for the results is needed")
        if _GUARD.get().force:
            return
        strange = _strange(folder)
        if strange is not None:
            raise BadInput(folder, "", f"holds {strange}: choose another folder with --out")
        _check_no_input_inside(folder)
    except OSError as error:
        raise BadInput(folder, "", f"cannot be used: {error.strerror}") from None


def is_replaceable(folder: Path) -> bool:
    """Return whether a whole folder may be replaced by new results."""
    return _strange(folder) is None and _input_inside(folder) is None


def made_by() -> dict[str, str]:
    """Return the entry of a results folder that names the command that made it."""
    return {"made_by": _GUARD.get().command} if _GUARD.get().command else {}


def _strange(folder: Path) -> str | None:
    """Return what in a folder this program did not make; None if all of it may be replaced."""
    names = sorted(path.name for path in folder.iterdir())
    if not names:
        return None
    maker = ""
    try:
        table = json.loads((folder / TABLE).read_text(encoding="utf-8"))
        ours = set(table["files"]) if table["kind"] == RESULTS else set()
        maker = table.get("made_by", "")
    except (OSError, ValueError, RecursionError, KeyError, TypeError):
        ours = set()
    if not ours:
        return "files and no results"
    command = _GUARD.get().command
    if maker and command and maker != command:
        return f"results of '{maker}'"
    return next((f"{name}, which is no result" for name in names if name not in ours), None)


def _check_no_input_inside(folder: Path) -> None:
    inside = _input_inside(folder)
    if inside is not None and not _GUARD.get().force:
        raise BadInput(folder, "", f"holds {inside.name}, an input: choose another folder")


def is_forced() -> bool:
    """Return whether the running command may overwrite anything."""
    return _GUARD.get().force


def is_input(path: Path) -> bool:
    """Return whether the running command reads a file."""
    return any(_same(path, given) for given in _GUARD.get().inputs)


def _input_inside(folder: Path) -> Path | None:
    target = folder.resolve()
    return next((given for given in _GUARD.get().inputs if target in given.resolve().parents), None)


def _is_there(path: Path) -> bool:
    try:
        return path.exists()
    except (OSError, ValueError):
        return False


def _same(path: Path, other: Path) -> bool:
    """Return whether two names are the same file, also through links."""
    if path.exists():
        return os.path.samefile(path, other)
    return path.resolve() == other.resolve()


def marked(text: str) -> str:
    """Return a file's text with a first line that marks it as written by this program.

    The line holds the text's fingerprint, so that a file edited since counts as a person's.

    Parameters
    ----------
    text : str
        With or without such a line; an existing one is replaced.
    """
    first, _, rest = text.partition("\n")
    body = rest if first.startswith(MADE) else text
    return f"{MADE}{hashlib.sha256(body.encode()).hexdigest()}\n{body}"


def is_marked(path: Path) -> bool:
    """Return whether a file is unchanged since `marked` made it."""
    text = path.read_bytes().decode("utf-8", "replace")
    return text.startswith(MADE) and marked(text) == text


def _is_json(kind: str, path: Path) -> bool:
    try:
        table = json.loads(path.read_bytes())
    except (ValueError, RecursionError):
        return False
    return isinstance(table, dict) and table.get("kind") == kind


def _is_archive(name: str, path: Path) -> bool:
    """Return whether a file is an archive whose description says that this program made it."""
    try:
        with zipfile.ZipFile(path) as archive:
            text = archive.read(name).decode("utf-8", "replace")
    except (zipfile.BadZipFile, KeyError, ValueError):
        return False
    return 'generationTool="spindle-drift' in text


def _never(path: Path) -> bool:
    return False


LOGS = (b"(", b"LOGG", b"date ", b"timestamp,", b"SQLite format 3")
"""First bytes of logs of frames: candump, BLF, ASC, CSV, SQLite."""


def _is_log(path: Path) -> bool:
    """Return whether a file is a log of frames, to which new frames are appended."""
    with path.open("rb") as file:
        begin = file.read(16)
    return not begin or begin.startswith(LOGS)


STATE_KIND = "spindle-drift FMU state"
STATE_BEGINS = json.dumps({"kind": STATE_KIND})[:-1].encode()
"""First bytes of a state file; a power cut may leave fewer, or none."""


def begins_as_state(data: bytes) -> bool:
    """Return whether a file's bytes are those of an FMU's state, or a truncated one.

    Parameters
    ----------
    data : bytes
        The beginning of the file, or all of it.
    """
    return STATE_BEGINS.startswith(data[: len(STATE_BEGINS)])


def _is_state(path: Path) -> bool:
    with path.open("rb") as file:
        return begins_as_state(file.read(len(STATE_BEGINS)))


def _is_page(path: Path) -> bool:
    """Return whether a file is an HTML page that names this program as its maker."""
    return b'<meta name="generator" content="spindle-drift">' in path.read_bytes()[:2000]


def _is_program(path: Path) -> bool:
    """Return whether a file is a program with a compiled-in compensator."""
    data = path.read_bytes()
    return data.startswith(b"\x7fELF") and b"compensator_step" in data


STATE = "state of an FMU"
RUN_FILE, LOG, PAGE, PROGRAM = "run file", "log of frames", "page", "program"
COMPENSATOR_FILE, MACHINE_FILE = "compensator file", "machine file"
SSP, FMU = "scenario package (.ssp)", "FMU"
KINDS: dict[str, Callable[[Path], bool]] = {
    COMPENSATOR_FILE: partial(_is_json, "spindle-drift compensator"),
    MACHINE_FILE: is_marked,
    STATE: _is_state,
    SSP: partial(_is_archive, "SystemStructure.ssd"),
    FMU: partial(_is_archive, "modelDescription.xml"),
    PAGE: _is_page,
    PROGRAM: _is_program,
    # A simulated run looks like a measured one.
    RUN_FILE: _never,
    LOG: _is_log,
}
"""By kind, the check that this program made a file, from its content."""
