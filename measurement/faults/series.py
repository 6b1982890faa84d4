"""Functions shared by the checks: valid readings, constant stretches."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from measurement.runs import FloatArray, Run
from measurement.units import UNITS, split_column

IntArray = npt.NDArray[np.int64]
FEWEST_SAMPLES = 5
"""Fewer equal samples in a row prove nothing, however far apart they are: set on no data."""
LASTS = 0.3
"""A leap or a move has lasted, or is gone, to within this share [1]. Set on the planted faults."""
UNUSUALLY = 3.0
"""This many times more than usual is wrong [1]: a standstill longer than the channel's others; a
level further off than the others' spread, or than their range at the start of the run, since on a
warm machine the hottest part looks like a wrong level; and what a compensator saw in training. Set
on the planted faults; docs/results.md reports compensators under it.
A frozen thermometer must also have missed this many steps of its resolution, and its own readings
must span as many: set on standstills planted into the lathe's odd runs."""
FAR_K = 10.0
"""A thermometer that alone moves, or is away from all others, by this much is wrong [K]. Set on the
planted faults."""
_NOT_READINGS = ("offset_", "error_")  # computed by a plant: an offset may rightly stand still


def lengths_of(run: Run) -> list[str]:
    """Return the columns of measured displacements."""
    return [name for name in run.displacements if not name.startswith(_NOT_READINGS)]


def valid(run: Run, column: str) -> tuple[IntArray, FloatArray]:
    """Return the rows that have a reading, and the readings."""
    values = run.frame[column].to_numpy()
    rows = np.flatnonzero(np.isfinite(values))
    return rows, values[rows]


def unit_of(column: str) -> str:
    """Return the unit of a difference of two readings, for messages."""
    unit = split_column(column)[1]
    return "K" if unit == "degC" else UNITS[unit].suffix


def stretches(values: FloatArray) -> tuple[IntArray, IntArray]:
    """Return the first and last index of every stretch of equal *values* [K, um]."""
    cuts = np.flatnonzero(np.diff(values) != 0.0) + 1
    return np.r_[0, cuts], np.r_[cuts, len(values)] - 1


def unchanged_for(time_s: FloatArray, values: FloatArray) -> FloatArray:
    """Return for each sample how long the series has had this exact value [s]; NaN is skipped."""
    there = np.flatnonzero(np.isfinite(values))
    age = np.zeros(len(values))
    if len(there):
        firsts, lasts = stretches(values[there])
        age[there] = time_s[there] - np.repeat(time_s[there[firsts]], lasts - firsts + 1)
    return age


def longest_unchanged(time_s: FloatArray, values: FloatArray) -> float:
    """Return the longest time for which a series stayed exactly constant [s], ignoring NaN.

    Parameters
    ----------
    time_s : array, shape (n,)
        Increasing [s].
    values : array, shape (n,)
        In any unit; NaN is missing.
    """
    return float(unchanged_for(time_s, values).max(initial=0.0))


def resolution_of(runs: Sequence[Run], column: str) -> float:
    """Return the smallest step between any two readings of a channel; 0 if it has only one."""
    levels = np.unique(np.concatenate([valid(run, column)[1] for run in runs]))
    # Sums of steps differ in their last digits, which are no steps.
    steps = np.diff(levels)
    steps = steps[steps > 1e-9 * max(1.0, float(np.abs(levels).max(initial=0.0)))]
    return float(steps.min()) if steps.size else 0.0
