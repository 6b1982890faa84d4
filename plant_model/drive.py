"""Inputs of a simulation on a grid of steps, held or interpolated depending on their kind."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from measurement.spectrum import SAME_SPEED_SHARE
from plant_model.machine import Input, Machine
from plant_model.parameters import FloatArray

if TYPE_CHECKING:
    import pandas as pd

SWITCH = SAME_SPEED_SHARE
"""If a held input changes by more than this share of its range, the grid has an instant there
[1]."""

MOST_STEPS = 1_000_000
"""Most steps of a run or a scenario, levels of a signal in it, or cases of a sweep: set on no
data."""


class DriveError(ValueError):
    """Inputs that cannot drive the machine."""


@dataclass(frozen=True)
class Drive:
    """Inputs of a simulation.

    Attributes
    ----------
    grid : array, shape (K + 1,)
        Instants between which the model steps [s].
    held : dict of str to array, shape (K,)
        Mean of speed, feed, torque and the like in each step.
    first, last : dict of str to array, shape (K,)
        Boundary temperatures at the start and end of each step [degC].
    rows : dict of str to array, shape (T,)
        All inputs at the given rows, gaps bridged.
    row_times : array, shape (T,)
        Times of the rows [s].
    """

    grid: FloatArray
    held: dict[str, FloatArray]
    first: dict[str, FloatArray]
    last: dict[str, FloatArray]
    rows: dict[str, FloatArray]
    row_times: FloatArray

    def first_boundaries(self, machine: Machine) -> FloatArray:
        """Return the boundary temperatures at the start, in the machine's order.

        Parameters
        ----------
        machine : Machine

        Returns
        -------
        array, shape (boundaries,)
            [degC]
        """
        return np.array([self.first[name][0] for name in machine.boundary_index])

    def is_like(self, other: Drive) -> bool:
        """Whether another drive has the same inputs on the same grid; their rows may differ."""
        if not np.array_equal(self.grid, other.grid) or self.held.keys() != other.held.keys():
            return False
        pairs = ((self.held, other.held), (self.first, other.first), (self.last, other.last))
        return all(
            np.array_equal(values, theirs[name])
            for mine, theirs in pairs
            for name, values in mine.items()
        )

    def refined(self, parts: int) -> Drive:
        """Return the same inputs with each step of the grid split into equal parts.

        Parameters
        ----------
        parts : int

        Returns
        -------
        Drive
        """
        if parts == 1:
            return self
        share = np.arange(parts) / parts
        grid = self.grid[:-1, None] + np.diff(self.grid)[:, None] * share
        first, last = {}, {}
        for name, begin in self.first.items():
            rise = self.last[name] - begin
            first[name] = np.ravel(begin[:, None] + rise[:, None] * share)
            last[name] = np.ravel(begin[:, None] + rise[:, None] * (share + 1.0 / parts))
        held = {name: np.repeat(values, parts) for name, values in self.held.items()}
        whole = np.append(np.ravel(grid), self.grid[-1])
        return Drive(whole, held, first, last, self.rows, self.row_times)

    def inputs_at(self, time_s: FloatArray) -> dict[str, FloatArray]:
        """Return all inputs at other instants: held ones as held, boundaries interpolated.

        Parameters
        ----------
        time_s : array, shape (n,)
            Within the run [s].

        Returns
        -------
        dict of str to array, shape (n,)
            By input, each in its unit.
        """
        row = np.clip(
            np.searchsorted(self.row_times, time_s, side="right") - 1, 0, len(self.row_times) - 1
        )
        return {
            name: values[row] if name in self.held else np.interp(time_s, self.row_times, values)
            for name, values in self.rows.items()
        }


def column_in(frame: pd.DataFrame, entry: Input) -> str | None:
    """Return the column of a run that holds an input; None if there is none.

    Parameters
    ----------
    frame : DataFrame
    entry : Input
        Its column is tried first, then its name with its unit, then its name only.
    """
    names = (entry.column, f"{entry.name}_{entry.unit}", entry.name)
    return next((name for name in names if name in frame.columns), None)


def outside_ranges(machine: Machine, frame: pd.DataFrame) -> dict[str, str]:
    """Return a text for each input that leaves the range that the machine file gives it.

    Parameters
    ----------
    machine : Machine
    frame : DataFrame
        As in `drive_from`.

    Returns
    -------
    dict of str to str
        Its first such value and what is allowed, by column.
    """
    texts = {}
    for entry in machine.inputs:
        column = column_in(frame, entry)
        values = np.asarray(frame[column] if column else (), dtype=np.float64)
        for k in np.flatnonzero((values < entry.low) | (values > entry.high))[:1]:
            reading = f"{values[k]:g} at {np.asarray(frame.get('time_s', frame.index))[k]:g} s"
            allowed = f"{entry.low:g}..{entry.high:g} {entry.unit}"
            texts[str(column)] = f"{reading} is outside {allowed}"
    return texts


def check_ranges(machine: Machine, frame: pd.DataFrame) -> None:
    """Refuse inputs outside the ranges that the machine file gives them.

    Parameters
    ----------
    machine : Machine
    frame : DataFrame
        As in `drive_from`.

    Raises
    ------
    DriveError
        For the first such value of an input.
    """
    for column, text in outside_ranges(machine, frame).items():
        raise DriveError(f"{column}: {text}")


def _series(frame: pd.DataFrame, entry: Input) -> FloatArray:
    """Return one input at the frame's rows; gaps hold, those of boundaries are interpolated."""
    column = column_in(frame, entry)
    if column is None:
        if entry.default is None:
            raise DriveError(f"{entry.column}: the machine needs this column as its {entry.name}")
        return np.full(len(frame), entry.default)
    try:
        given = frame[column].to_numpy(dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise DriveError(f"{column}: {error}") from None
    present = np.isfinite(given)
    if not present.any():
        raise DriveError(f"{column}: no value in the whole run")
    time = frame["time_s"].to_numpy(dtype=np.float64)
    if entry.is_boundary:
        return np.asarray(np.interp(time, time[present], given[present]))
    place = np.maximum.accumulate(np.where(present, np.arange(len(given)), -1))
    return np.where(place >= 0, given[np.maximum(place, 0)], given[present][0])


def switched(
    machine: Machine, series: Mapping[str, FloatArray], time: FloatArray, step_s: float
) -> npt.NDArray[np.bool_]:
    """Return at which rows a held input has switched since the row before, shape (rows,).

    An input that jumps at nearly every step is noisy, or a ramp: its mean in each step is enough.

    Parameters
    ----------
    machine : Machine
    series : mapping of str to array, shape (rows,)
        Inputs by name; those that are missing do not switch.
    time : array, shape (rows,)
        [s]
    step_s : float
        Step of the simulation [s].
    """
    most = 0.5 * (time[-1] - time[0]) / step_s + 1.0
    at = np.zeros(len(time), dtype=bool)
    for entry in machine.inputs:
        if entry.is_boundary or entry.name not in series:
            continue
        jumps = np.abs(np.diff(series[entry.name])) > SWITCH * (entry.high - entry.low)
        if jumps.sum() <= most:
            at[1:] |= jumps
    return at


def drive_from(
    machine: Machine,
    frame: pd.DataFrame,
    step_s: float,
    at: FloatArray | None = None,
) -> Drive:
    """Put the inputs of a run on a grid.

    Parameters
    ----------
    machine : Machine
        Says which inputs there are and which columns hold them.
    frame : DataFrame
        ``time_s`` and the inputs, by run column or by input name.
    step_s : float
        Longest step [s]. The grid has an instant at each row, unless rows are denser than that,
        and wherever a held input switches.
    at : array, optional
        Instants of the grid instead of the rows [s]; equal steps are faster than uneven rows.

    Returns
    -------
    Drive
        Inputs at the rows and on the grid.

    Raises
    ------
    DriveError
        For fewer than two rows, time that does not increase or leaps too far, or an input that is
        missing or no number.
    """
    if "time_s" not in frame.columns:
        raise DriveError("time_s: the inputs need this column")
    time = frame["time_s"].to_numpy(dtype=np.float64)
    if len(time) < 2 or not np.all(np.diff(time) > 0.0):
        raise DriveError("time_s: at least two rows are needed, and time must ascend")
    if not step_s > 0.0:
        raise DriveError(f"step_s: {step_s:g} must be above 0")
    steps = (time[-1] - time[0]) / step_s
    if steps > MOST_STEPS:
        leap = int(np.argmax(np.diff(time)))
        raise DriveError(
            f"time_s: {time[leap + 1]:g} after {time[leap]:g} s is too far: a run may have "
            f"{MOST_STEPS} steps of {step_s:g} s"
        )
    series = {entry.name: _series(frame, entry) for entry in machine.inputs}
    # Rows are instants of the grid, thinned if they are denser than the steps.
    every = max(1, int(step_s / np.median(np.diff(time)) + 1e-9))
    rows = time[::every] if at is None else np.append(time[0], at[(at > time[0]) & (at < time[-1])])
    switches = time[switched(machine, series, time, step_s)]
    fixed = np.unique(np.concatenate([rows, time[-1:], switches]))
    grid = np.append(_cut(fixed, step_s), time[-1])
    held: dict[str, FloatArray] = {}
    first: dict[str, FloatArray] = {}
    last: dict[str, FloatArray] = {}
    for entry in machine.inputs:
        values = series[entry.name]
        if not entry.is_boundary:
            held[entry.name] = _step_means(time, values, grid)
        else:
            on_grid = np.interp(grid, time, values)
            first[entry.name], last[entry.name] = on_grid[:-1], on_grid[1:]
    return Drive(grid, held, first, last, series, time)


def _step_means(time: FloatArray, values: FloatArray, grid: FloatArray) -> FloatArray:
    """Return the mean over each step of a series that holds each value until the next row."""
    row = np.clip(np.searchsorted(time, grid[:-1], side="right") - 1, 0, len(values) - 1)
    row_of_end = np.clip(np.searchsorted(time, grid[1:], side="left") - 1, 0, len(values) - 1)
    area = np.concatenate([[0.0], np.cumsum(values[:-1] * np.diff(time))])

    def integral(at: FloatArray, rows: npt.NDArray[np.int64]) -> FloatArray:
        return np.asarray(area[rows] + values[rows] * (at - time[rows]))

    mean = (integral(grid[1:], row_of_end) - integral(grid[:-1], row)) / np.diff(grid)
    # If nothing changes in a step, its value is kept to the last bit.
    changes = np.concatenate([[0], np.cumsum(np.diff(values) != 0.0)])
    return np.where(changes[row] == changes[row_of_end], values[row], mean)


def levels_of(values: FloatArray, span: float) -> FloatArray:
    """Return an input as conductances see it: rounded to half a switch if it has many levels."""
    width = SWITCH / 2.0 * span
    if len(np.unique(values)) * width <= span:
        return values
    return np.asarray(np.round(values / width) * width)


def _cut(fixed: FloatArray, step_s: float) -> FloatArray:
    """Return the starts of the equal parts, no longer than *step_s*, between instants [s]."""
    parts = np.maximum(1, np.ceil(np.diff(fixed) / step_s - 1e-9).astype(np.intp))
    within = np.arange(parts.sum()) - np.repeat(np.cumsum(parts) - parts, parts)
    return np.asarray(
        within * np.repeat(np.diff(fixed) / parts, parts) + np.repeat(fixed[:-1], parts)
    )
