"""Check a package and write it to a folder with its reference results, all or nothing."""

from __future__ import annotations

import contextlib
import os
import tempfile
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path

from fmpy.validation import validate_fmu

from fmu_packaging.layered import reference_files
from fmu_packaging.package import Package
from fmu_packaging.reference import Profile, RunError, input_csv, options_text, run_apart


class PublishError(RuntimeError):
    """An FMU that cannot be published; the text says why, with one line per problem."""


class UnwritableError(PublishError):
    """A folder that cannot be written to, for example on a full disk; the text is one line."""


@dataclass(frozen=True)
class Reference:
    """Inputs over time, length and step of the reference run [s]."""

    profiles: Mapping[str, Profile]
    stop_s: float
    step_s: float
    every_s: float = 60.0


def publish(package: Package, folder: Path, reference: Reference) -> tuple[Path, bool]:
    """Validate an FMU, run it in a fresh process, and write it with its reference results.

    Parameters
    ----------
    package : Package
    folder : Path
        Created if missing. Its files are only replaced if everything is in order.
    reference : Reference

    Returns
    -------
    path : Path
        The FMU.
    written : bool
        False if the same FMU was already there.

    Raises
    ------
    PublishError
        If the validation finds a problem, the run fails, or the folder cannot be written to.
    """
    target = folder / f"{package.name}.fmu"
    inputs = input_csv(reference.profiles, reference.stop_s, reference.every_s)
    beside = {
        folder / f"{package.name}_in.csv": inputs,
        folder / f"{package.name}_ref.opt": options_text(reference.stop_s, reference.step_s),
    }
    result = folder / f"{package.name}_ref.csv"
    same = target.is_file() and result.is_file()
    if same:
        recorded = result.read_text(encoding="utf-8")
        same = target.read_bytes() == _with_run(package, reference, inputs, recorded)
    if same and all(path.is_file() and path.read_text() == text for path, text in beside.items()):
        return target, False
    with tempfile.TemporaryDirectory(prefix="fmu_check_") as apart, _writing(Path(apart)):
        candidate = Path(apart) / target.name
        candidate.write_bytes(package.zipped(on_trial=True))
        problems = validate_fmu(str(candidate))
        if problems:
            raise PublishError("\n".join(problems))
        try:
            outputs = run_apart(candidate, inputs, reference.stop_s, reference.step_s)
        except RunError as error:
            raise PublishError(f"the reference run failed:\n{error}") from None
    texts = {path: text.encode() for path, text in {**beside, result: outputs}.items()}
    data = _with_run(package, reference, inputs, outputs)
    # Last, so that an FMU in the folder is always next to its own reference results.
    _put({**texts, target: data}, folder)
    return target, True


def _with_run(package: Package, reference: Reference, inputs: str, result: str) -> bytes:
    """Return the FMU with its reference run added; the GUID does not depend on it."""
    times = reference.stop_s, reference.step_s
    carried = reference_files(package.name, *times, inputs, result, package.files)
    return replace(package, files={**package.files, **carried}).zipped()


def _put(files: Mapping[Path, bytes], folder: Path) -> None:
    """Write all files under temporary names, synced to disk, before renaming any of them."""
    is_new = not folder.exists()
    with _writing(folder):
        folder.mkdir(parents=True, exist_ok=True)
        try:
            _put_into(folder, files)
        except BaseException:
            if is_new:
                folder.rmdir()
            raise


def _put_into(folder: Path, files: Mapping[Path, bytes]) -> None:
    with tempfile.TemporaryDirectory(dir=folder, prefix=".fmu_") as apart:
        for path, data in files.items():
            with (Path(apart) / path.name).open("xb") as stream:
                stream.write(data)
                stream.flush()
                os.fsync(stream.fileno())
        for path in files:
            (Path(apart) / path.name).replace(path)


@contextlib.contextmanager
def _writing(folder: Path) -> Iterator[None]:
    try:
        yield
    except OSError as error:
        raise UnwritableError(f"{folder}: cannot be written: {error.strerror or error}") from None
