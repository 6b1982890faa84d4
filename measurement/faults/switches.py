"""When a run switched speed, feed, torque, power or flow, near which readings may really leap."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from measurement.resampling import SLOW_S
from measurement.runs import Run
from measurement.spectrum import SAME_SPEED_SHARE

BoolArray = npt.NDArray[np.bool_]

_SWITCHED = ("rpm", "mm_min", "Nm", "W", "lpm")


def near_switch(run: Run, after_s: float = SLOW_S) -> BoolArray:
    """Return which rows are near a switch of speed, feed, torque, power or flow, shape (rows,).

    Parameters
    ----------
    run : Run
    after_s : float
        How long after a switch a row still counts as near [s].
    """
    time = run.time_s
    # Switches before the first sample are unknown.
    near: BoolArray = time <= time[0] + after_s
    for at in np.flatnonzero(switched_after(run)).tolist():
        near |= (time >= time[at] - SLOW_S) & (time <= time[at + 1] + after_s)
        # With coarse sampling the samples on both sides count, however far apart.
        near[max(0, at - 1) : at + 3] = True
    return near


def switched_after(run: Run) -> BoolArray:
    """Return after which rows something was switched, shape (rows - 1,)."""
    switched = np.zeros(max(len(run.time_s) - 1, 0), dtype=bool)
    for unit in _SWITCHED:
        for column in run.of_unit(unit):
            values = run.frame[column].ffill().bfill().to_numpy()
            moves = np.abs(np.diff(values))
            limit = SAME_SPEED_SHARE * float(np.ptp(values))
            switched |= (moves > limit) & (moves > 0.0)
    return switched
