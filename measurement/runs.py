"""Run files: the recording of a rig, one column per signal.

A run file is a CSV file in UTF-8. Its header names each column by signal and unit (see
:mod:`measurement.units`); ``time_s`` comes first and increases. Sampling may be uneven.
An empty cell or ``NaN`` is a missing value.
"""

from __future__ import annotations

import csv
import hashlib
import io
import math
import re
from collections.abc import Collection, Iterator
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np
import numpy.typing as npt
import pandas as pd

from measurement.errors import BadInput, shown
from measurement.files import read_bytes, sha256_of, write_atomically
from measurement.resampling import resample
from measurement.units import UNITS, split_column

if TYPE_CHECKING:
    from measurement.faults.fault import Fault

FloatArray: TypeAlias = npt.NDArray[np.float64]

TIME = "time_s"
_SPACE = " \t\f\v"
_MISSING = ("", "NaN", "nan", "NAN")
_NUMBER = re.compile(
    r"\s*[+-]?(?:(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]+)?|inf|infinity)\s*",
    re.ASCII | re.IGNORECASE,
)
# From 3.1 on pandas reads numbers to the last digit by default, and warns if asked to.
_PANDAS = tuple(int(part) for part in pd.__version__.split(".")[:2])
_EXACT: dict[str, Any] = {} if _PANDAS >= (3, 1) else {"float_precision": "round_trip"}
FIRST_ROW = 2
"""The line number of the first data row, given by the run file: the header is line 1."""

HOUR_S = 3600.0
"""By this much clocks are set in spring and autumn [s]."""

LONGEST_S = 1e8
"""Longest run or scenario [s], three years: beyond, a clock has leapt. Set on no data."""

NO_ROWS = "row 2", "there are no data rows; at least one is needed"


@dataclass(frozen=True, eq=False)
class Run:
    """A recorded (or simulated) run.

    Parameters
    ----------
    name : str
        Name in reports; that of the file without its extension.
    frame : DataFrame
        ``time_s`` [s] first, then one column per signal, all of them floats; NaN for a missing
        value. A copy is taken.
    path : Path, optional
        The file that it was read from.
    digest : str, optional
        SHA-256 of that file when it was read.
    faults : tuple of Fault, optional
        Faults found by `measurement.faults.looked_over`; None if it was not checked.

    Raises
    ------
    BadInput
        If the frame breaks a rule of run files.
    """

    name: str
    frame: pd.DataFrame
    path: Path | None = None
    digest: str = field(default="", repr=False)
    faults: tuple[Fault, ...] | None = field(default=None, repr=False)

    def __post_init__(self) -> None:
        """Check the frame and take a copy of it."""
        source = self.path or self.name
        _check_header([str(name) for name in self.frame.columns], source)
        try:
            frame = self.frame.astype(np.float64).reset_index(drop=True)
        except (TypeError, ValueError) as error:
            raise BadInput(source, "", f"a column is not numeric: {error}") from None
        _check_values(frame, source)
        object.__setattr__(self, "frame", frame)

    @cached_property
    def time_s(self) -> FloatArray:
        """Time of every sample, shape (samples,) [s]."""
        return self.frame[TIME].to_numpy()

    @property
    def temperatures(self) -> list[str]:
        """The columns of temperatures [degC], in the file's order."""
        return self.of_unit("degC")

    @property
    def displacements(self) -> list[str]:
        """The columns of displacements [um], in the file's order."""
        return self.of_unit("um")

    def of_unit(self, unit: str) -> list[str]:
        """Return the columns of a unit except time, in the file's order.

        Parameters
        ----------
        unit : str
            A suffix of `measurement.units.UNITS`, such as ``degC``.
        """
        names = [str(name) for name in self.frame.columns]
        return [name for name in names[1:] if split_column(name)[1] == unit]

    @property
    def sha256(self) -> str:
        """Fingerprint of the file, or of the text that :func:`write_run` would write."""
        if self.digest:
            return self.digest
        if self.path is not None:
            return sha256_of(self.path)
        return hashlib.sha256(run_text(self).encode("utf-8")).hexdigest()

    def fingerprint(self, temperatures: Collection[str] | None = None) -> str:
        """Return the SHA-256 of the numbers, in whatever file they are.

        Parameters
        ----------
        temperatures : collection of str, optional
            The signals that count beside times and displacements; by default all columns count.
        """
        names = sorted(map(str, self.frame.columns[1:]))
        if temperatures is not None:
            columns = {*map("{}_degC".format, temperatures), *self.displacements}
            names = [name for name in names if name in columns]
        # Single precision: a spreadsheet that writes fifteen digits does not make another run.
        values = self.frame[[TIME, *names]].to_numpy("<f4") + 0.0
        return hashlib.sha256(",".join(names).encode("utf-8") + values.tobytes()).hexdigest()

    def resampled(self, step_s: float) -> Run:
        """Return the run resampled to an even time grid.

        Measured quantities are averaged over one step where the grid is coarser than the samples
        and interpolated linearly where it is finer; quantities that switch (speed, feed, torque,
        flow, tool length, flags) hold their last value. Missing values stay missing, and so do gaps
        of more than five of a column's median intervals, or one step if that is longer.

        Parameters
        ----------
        step_s : float
            Step of the grid, which begins with the run; more than 0 [s].

        Returns
        -------
        Run
            With the same columns.

        Raises
        ------
        ValueError
            If the step is not positive, or the grid has more than 10 million rows.
        """
        grid = _grid(float(self.time_s[0]), float(self.time_s[-1]), step_s)
        columns: dict[str, FloatArray] = {TIME: grid}
        for name in [str(name) for name in self.frame.columns[1:]]:
            columns[name] = resample(
                self.time_s,
                self.frame[name].to_numpy(),
                grid,
                step_s,
                holds=UNITS[split_column(name)[1]].switches,
            )
        return Run(self.name, pd.DataFrame(columns))


def read_run(path: str | Path) -> Run:
    """Read and check a run file.

    Parameters
    ----------
    path : str or path

    Returns
    -------
    Run
        Named after the file, with its path and SHA-256.

    Raises
    ------
    BadInput
        One line that names file, row (line number, the header is 1), column, value and what is
        allowed.
    """
    path = Path(path)
    data = read_bytes(path)
    try:
        text = _decoded(data, path)
        frame = _fast_frame(text, path)
        if frame is None:
            frame = _slow_frame(text, path)
        return Run(path.stem, frame, path, hashlib.sha256(data).hexdigest())
    except BadInput as error:
        raise _with_way_out(error, path) from None


def write_run(run: Run | pd.DataFrame, path: str | Path) -> Path:
    """Write a run file, whole or not at all; reading it back gives the same numbers.

    Parameters
    ----------
    run : Run or DataFrame
        A frame is checked like a run file.
    path : str or path
        Replaced if it exists; missing folders are created.

    Returns
    -------
    Path
        The path given.

    Raises
    ------
    BadInput
        If the frame breaks a rule of run files, or the file cannot be written.
    """
    path = Path(path)
    checked = run if isinstance(run, Run) else Run(path.stem, run)
    return write_atomically(path, run_text(checked))


def run_text(run: Run) -> str:
    """Return the text of a run file."""
    return str(run.frame.to_csv(index=False, lineterminator="\n"))


def _with_way_out(refusal: BadInput, path: Path) -> BadInput:
    """Return a refusal that names the importer if that does read the file."""
    from measurement.importing.log import import_files  # which makes runs

    try:
        import_files([path])
    except BadInput:
        return refusal
    told = f"{refusal.problem}; spindle-drift import reads this file"
    return BadInput(refusal.source, refusal.place, told)


def _grid(start: float, end: float, step: float) -> FloatArray:
    if not (math.isfinite(step) and step > 0.0):
        raise ValueError(f"step_s is {step:g}; it must be more than 0")
    # Slightly more than the quotient, so that rounding never drops the last step.
    steps = (end - start) / step * (1.0 + 1e-12)
    if not steps < 1e7:
        raise ValueError(f"step_s is {step:g}: more than 10 million rows from {start:g} to {end:g}")
    grid: FloatArray = start + step * np.arange(int(steps) + 1, dtype=np.float64)
    return np.minimum(grid, end)  # rounding must not take the last row out of the run


def _decoded(data: bytes, path: Path) -> str:
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        row = data.count(b"\n", 0, error.start) + 1
        problem = f"byte 0x{data[error.start]:02x} is not UTF-8; the file must be UTF-8 text"
        raise BadInput(path, f"row {row}", problem) from None
    text = text.replace("\r\n", "\n").replace("\r", "\n")
    if "\0" in text:
        row = text.count("\n", 0, text.index("\0")) + 1
        raise BadInput(path, f"row {row}", "holds a null character; the file must be text")
    text = text.rstrip("\n")
    if not text.strip():
        raise BadInput(path, "", "is empty; a header and data rows are needed")
    return text


def _fast_frame(text: str, path: Path) -> pd.DataFrame | None:
    """Return the frame of a regular file; None if it must be read cell by cell."""
    header, _, body = text.partition("\n")
    if '"' in text:
        return None
    names = [name.strip() for name in header.split(",")]
    _check_header(names, path)
    if not body:
        raise BadInput(path, *NO_ROWS)
    commas = len(names) - 1
    for row, line in enumerate(body.split("\n"), FIRST_ROW):
        if line.count(",") != commas:
            _check_width(line.count(",") + 1 if line else 0, len(names), row, path)
    try:
        frame: pd.DataFrame = pd.read_csv(
            io.StringIO(body),
            header=None,
            names=names,
            keep_default_na=False,
            na_values=list(_MISSING),
            skip_blank_lines=False,
            low_memory=False,
            **_EXACT,
        )
    except (ValueError, OverflowError):
        return None
    # Read without a dtype: with one, True and False would pass as numbers.
    numeric = all(kind.kind in "iuf" for kind in frame.dtypes)
    return frame if numeric else None


def _slow_frame(text: str, path: Path) -> pd.DataFrame:
    """Read cell by cell and refuse the first cell that is not a number."""
    rows = _rows(text, path)
    _, header = next(rows)
    names = [name.strip() for name in header]
    _check_header(names, path)
    table: list[list[float]] = []
    for row, cells in rows:
        _check_width(len(cells), len(names), row, path)
        table.append(
            [_number(cell, row, name, path) for name, cell in zip(names, cells, strict=True)]
        )
    if not table:
        raise BadInput(path, *NO_ROWS)
    return pd.DataFrame(np.array(table, dtype=np.float64), columns=names)


def _rows(text: str, path: Path) -> Iterator[tuple[int, list[str]]]:
    """Yield the line number and the cells of every row."""
    reader = csv.reader(io.StringIO(text), strict=True)
    start = 1
    try:
        for cells in reader:
            yield start, cells
            start = reader.line_num + 1
    except csv.Error as error:
        raise BadInput(path, f"row {start}", f"is not a CSV row: {error}") from None


def _number(cell: str, row: int, name: str, path: Path) -> float:
    if cell.strip(_SPACE) in _MISSING:
        return math.nan
    if not _NUMBER.fullmatch(cell):
        problem = f"{shown(cell)} is not a number; a number, an empty cell or NaN is allowed"
        raise BadInput(path, f"row {row}, column {name}", problem)
    return float(cell)


def _check_width(cells: int, wanted: int, row: int, path: Path) -> None:
    if cells == wanted:
        return
    what = f"has {cells} {'cell' if cells == 1 else 'cells'}" if cells else "is blank"
    problem = f"{what}; the header names {wanted} {'column' if wanted == 1 else 'columns'}"
    raise BadInput(path, f"row {row}", problem)


def _check_header(names: list[str], source: str | Path) -> None:
    if not names or names[0] != TIME:
        first = shown(names[0]) if names else "missing"
        problem = f"is {first}; it must be {TIME}, with commas between the columns"
        raise BadInput(source, "row 1, first column", problem)
    seen: dict[str, int] = {}
    for number, name in enumerate(names, 1):
        place = f"row 1, column {number}"
        if name in seen:
            raise BadInput(source, place, f"{shown(name)} is also column {seen[name]}")
        seen[name] = number
        if not name.isprintable():
            raise BadInput(source, place, f"{shown(name)} holds a character that cannot be printed")
        try:
            split_column(name)
        except ValueError:
            units = " ".join("_" + suffix for suffix in UNITS)
            problem = f"{shown(name)} has no known unit; a signal's name and one of {units}"
            raise BadInput(source, place, problem + " is allowed") from None


def _check_values(frame: pd.DataFrame, source: str | Path) -> None:
    if frame.empty:
        raise BadInput(source, *NO_ROWS)
    values = frame.to_numpy()
    units = [UNITS[split_column(str(name))[1]] for name in frame.columns]
    low, high = (np.array([getattr(unit, end) for unit in units]) for end in ("low", "high"))
    wrong = (values < low) | (values > high)
    if wrong.any():
        row, at = (int(i) for i in np.argwhere(wrong)[0])
        value, unit = float(values[row, at]), units[at]
        word = f"is outside {unit.low:g}..{unit.high:g} {unit.suffix}"
        if math.isinf(value):
            word = "is infinite; a finite number, an empty cell or NaN is allowed"
        place = f"row {row + FIRST_ROW}, column {frame.columns[at]}"
        raise BadInput(source, place, f"{value:g} {word}")
    _check_time(values[:, 0], source)


def _check_time(time: FloatArray, source: str | Path) -> None:
    def refused(at: int, problem: str) -> BadInput:
        return BadInput(source, f"row {at + FIRST_ROW}, column {TIME}", problem)

    missing = np.flatnonzero(np.isnan(time))
    if missing.size:
        raise refused(int(missing[0]), "is missing; every row needs a time")
    steps = np.diff(time)
    back = np.flatnonzero(steps <= 0.0)
    if back.size:
        at = int(back[0]) + 1
        problem = f"{float(time[at])!r} is not after {float(time[at - 1])!r}, the previous row"
        problem += "; time must grow from row to row"
        if round(steps[at - 1] / HOUR_S) == -1:
            problem += f"; if the clock was set back by an hour, add {HOUR_S:g} s from there on"
        raise refused(at, problem)
    if time[-1] - time[0] > LONGEST_S:
        at = int(np.argmax(steps)) + 1
        problem = f"{time[at]:g} after {time[at - 1]:g}, the previous row, is too late"
        raise refused(at, f"{problem}; a run may last {LONGEST_S:g} s")
