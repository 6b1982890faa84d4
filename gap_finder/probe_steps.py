"""Small steps in one displacement probe: the probe slipped and has a new zero from then on.

A machine does not leap by itself, except when a floating bearing slips, which happens repeatedly
and only along the axis. So a leap of a few micrometres in one probe, without a switch nearby or a
leap in another channel, is a fault of that probe rather than physics. Only its zero is lost; the
readings after it are as good as before. (Leaps of 25 um and more are found with the other broken
channels, and the readings after them are not used.)
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt
from scipy.ndimage import maximum_filter1d, median_filter

from gap_finder.observations import DISPLACEMENT_TOLERANCE
from measurement.faults.series import UNUSUALLY
from measurement.faults.switches import near_switch
from measurement.runs import Run
from plant_model.effects.base import POSE
from plant_model.machine import Machine
from plant_model.parameters import FloatArray
from plant_model.sensors import column_of, displacement_names, displacements

ROWS = 6
"""Number of rows before and after a leap through which lines are fitted; set on no data."""

USUAL = 0.95
"""A leap is `UNUSUALLY` larger than this quantile of the probe's moves between rows, rows without a
move left out [1]: a probe with coarse resolution, or one that leaps all the time, has not slipped.
Set on no data. Steps of 1, 3 and 10 um planted into the real lathe's 30 runs are found or not, and
sound runs left alone, as with two more limits (2 um, and 8 times the scatter of the lines)."""


@dataclass(frozen=True)
class ProbeStep:
    """A probe that slipped.

    Attributes
    ----------
    channel : str
    time_s : float
        First row after the step [s].
    leap_um : float
        Change of its zero [um].
    """

    channel: str
    time_s: float
    leap_um: float

    def text(self, run: str) -> str:
        """Return one readable line."""
        return (
            f"{self.channel} in {run}: leaps by {self.leap_um:+.1f} um at {self.time_s / 60:.0f} "
            "min, alone and with no switch near; its zero is taken anew from there"
        )


def probe_steps(machine: Machine, runs: Sequence[Run]) -> list[tuple[ProbeStep, ...]]:
    """Return the steps of single probes in every run, in order of time."""
    by_run = [_steps_in(machine, run) for run in runs]
    times = Counter(step.channel for steps in by_run for step in steps)
    # Repeated leaps along the axis, even if in different runs, come from a bearing, not a probe.
    slipping = {
        name
        for name, share in moved_by_elongation(machine).items()
        if abs(share) > 1e-9 and times[name] > 1
    }
    return [tuple(step for step in steps if step.channel not in slipping) for steps in by_run]


def put_back(machine: Machine, run: Run, steps: Sequence[ProbeStep]) -> Run:
    """Return a run with the steps of slipped probes removed."""
    if not steps:
        return run
    frame = run.frame.copy()
    for step in steps:
        column = column_of(machine, step.channel)
        frame.loc[run.time_s >= step.time_s, column] -= step.leap_um
    return replace(run, frame=frame)


def moved_by_elongation(machine: Machine) -> dict[str, float]:
    """Return how far each displacement moves with elongation [um/um]."""
    unit = np.zeros(len(POSE))
    unit[POSE.index("elongation")] = 1.0
    return {name: float(np.ravel(um)[0]) for name, um in displacements(machine, unit).items()}


def _steps_in(machine: Machine, run: Run) -> list[ProbeStep]:
    quiet = ~near_switch(run)
    columns = {name: column_of(machine, name) for name in displacement_names(machine)}
    series = {
        column: _leaps(run.time_s, run.frame[column].to_numpy(dtype=np.float64))
        for column in run.frame.columns
        if column.endswith(("_um", "_degC"))
    }
    steps = []
    for name, column in columns.items():
        if column not in series:
            continue
        leaps = series[column]
        for row in _outstanding(leaps, quiet):
            size = float(leaps.size[row])
            others = (other for key, other in series.items() if key != column)
            if not any(_with_it(other, row) for other in others):
                steps.append(ProbeStep(name, float(run.time_s[row]), size))
    return sorted(steps, key=lambda step: step.time_s)


@dataclass(frozen=True)
class _Leaps:
    """Leaps of a channel between each row and the row before it.

    Attributes
    ----------
    size : array, shape (rows,)
        Between lines through the rows before and after; NaN if there are too few.
    move : array, shape (rows,)
        From one reading to the next.
    usual : float
        The usual largest move between rows.
    """

    size: FloatArray
    move: FloatArray
    usual: float


def _leaps(time: FloatArray, values: FloatArray) -> _Leaps:
    size, move = np.full(len(values), np.nan), np.full(len(values), np.nan)
    rows = np.flatnonzero(np.isfinite(values))
    readings, instants = values[rows], time[rows]
    moves = np.diff(readings)
    usual = _usual_move(moves)
    if len(rows) < 4 * ROWS:
        return _Leaps(size, move, usual)
    parts, times = (np.lib.stride_tricks.sliding_window_view(x, ROWS) for x in (readings, instants))
    middle, level = times.mean(axis=1), parts.mean(axis=1)
    from_middle = times - middle[:, None]
    slope = np.sum(from_middle * parts, axis=1) / np.sum(from_middle**2, axis=1)
    # Window k ends where window k + ROWS begins; the leap lies between the two.
    first, second = slice(0, len(level) - ROWS), slice(ROWS, None)
    at = slice(ROWS, len(rows) - ROWS + 1)
    between = (instants[at] + instants[ROWS - 1 : len(rows) - ROWS]) / 2.0
    before = level[first] + slope[first] * (between - middle[first])
    after = level[second] + slope[second] * (between - middle[second])
    size[rows[at]] = after - before
    move[rows[at]] = moves[ROWS - 1 : len(rows) - ROWS]
    return _Leaps(size, move, usual)


def _usual_move(moves: FloatArray) -> float:
    """Return the `USUAL` quantile of a probe's moves between rows, rows without a move left out.

    The median of the neighbouring moves is the machine's warming and is subtracted.
    """
    sizes = np.abs(moves[moves != 0.0] - median_filter(moves, ROWS + 1)[moves != 0.0])
    return float(np.quantile(sizes, USUAL)) if sizes.size else 0.0


def _outstanding(leaps: _Leaps, quiet: npt.NDArray[np.bool_]) -> list[int]:
    """Return the rows at which a probe leaps by itself."""
    size = np.abs(np.nan_to_num(leaps.size))
    limit = max(DISPLACEMENT_TOLERANCE, UNUSUALLY * leaps.usual)
    outstanding = (size > limit) & quiet & (size == maximum_filter1d(size, 2 * ROWS + 1))
    # Most of it happens between two rows.
    outstanding &= 2.0 * np.nan_to_num(leaps.move * np.sign(leaps.size)) > size
    return np.flatnonzero(outstanding).tolist()


def _with_it(other: _Leaps, row: int) -> bool:
    """Whether another channel also leaps near a row."""
    near = np.abs(np.nan_to_num(other.size[max(row - 1, 0) : row + 2]))
    return bool(near.max(initial=0.0) > UNUSUALLY * other.usual)
