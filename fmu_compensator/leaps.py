"""Leaps of the remaining drift: a displacement sensor that slipped, or a joint of the machine.

The drift itself moves all the time, so a slip of a few micrometres is hard to see in it. What the
compensator leaves is nearly still.
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
import pandas as pd

from fmu_compensator.driving import Driven, rows_used
from fmu_compensator.fit.training import Array
from measurement.faults.leaping import BESIDE, leap_odds
from measurement.faults.series import FEWEST_SAMPLES, LASTS
from measurement.faults.switches import near_switch
from measurement.rig import AXES
from measurement.runs import Run


def leaps_of(run: Run, driven: Driven) -> dict[str, str]:
    """Return the largest leap of the remaining drift along each axis that has one, in words.

    A leap stands out from the moves beside it, lasts, exceeds the half width of the interval, and
    is not near a switch of the machine, which may really move the spindle at once. The drift leaps
    too: after a fault, only the offset may.

    Parameters
    ----------
    run : Run
    driven : Driven
        What the compensator did in it.

    Returns
    -------
    dict of str to str
        By axis.
    """
    return _leaps(run, driven.time_s, driven.drift, driven.error, driven.half_width)


def leap_lines(found: Iterable[tuple[str, Iterable[str]]]) -> list[str]:
    """Return a line for each leap of the remaining drift.

    Parameters
    ----------
    found : iterable of (str, iterable of str)
        Runs, each with its leaps in words.
    """
    return [
        f"{name}: {leap}; if a displacement sensor slipped, leave this run out"
        for name, leaps in found
        for leap in leaps
    ]


def leap_lines_of(run: Run, frame: pd.DataFrame) -> list[str]:
    """Return the same for ``drift_X_um``, ``error_X_um``, ``dX_uncertainty_um`` ... of a run."""
    drift, error, width = (
        frame.reindex(columns=[name.format(axis) for axis in AXES]).to_numpy(float)
        for name in ("drift_{}_um", "error_{}_um", "d{}_uncertainty_um")
    )
    rows = rows_used(run.time_s, drift)
    width = np.where(width >= 0.0, width, np.nan)  # -1: not known
    leaps = _leaps(run, run.time_s[rows], drift[rows], error[rows], width[rows])
    return leap_lines([(run.name, leaps.values())])


def _leaps(
    run: Run, time_s: Array, drift: Array, error: Array, half_width: Array
) -> dict[str, str]:
    near = near_switch(run)[np.searchsorted(run.time_s, time_s)]
    found: dict[str, str] = {}
    for place, axis in enumerate(AXES):
        rows = np.flatnonzero(np.isfinite(error[:, place]))
        left, width = error[rows, place], half_width[rows, place]
        if len(rows) < 2 * FEWEST_SAMPLES:
            continue
        moves = np.diff(left)
        large = (leap_odds(left, 0.0) > 0.0) & (np.abs(moves) > width[1:])
        large &= np.abs(np.diff(drift[rows, place])) > width[1:]
        large &= ~(near[rows[1:]] | near[rows[:-1]])
        lasting = [k for k in np.flatnonzero(large).tolist() if _lasts(left, k)]
        if lasting:
            k = max(lasting, key=lambda k: abs(moves[k]))
            minutes = time_s[rows[k + 1]] / 60.0
            found[axis] = f"{axis} leaps by {moves[k]:+.1f} um at {minutes:.0f} min and stays there"
    return found


def _lasts(left: np.ndarray, k: int) -> bool:
    """Return whether the readings on either side are as far apart as the leap between them."""
    before, after = left[max(k + 1 - BESIDE, 0) : k + 1], left[k + 1 : k + 1 + BESIDE]
    by = left[k + 1] - left[k]
    return bool(abs(np.median(after) - np.median(before) - by) <= LASTS * abs(by))
