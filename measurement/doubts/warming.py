"""How the machine as a whole warms in a run: the basis of doubts about units and places."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from measurement.resampling import FloatArray
from measurement.runs import Run

FEWEST_LIKE_RUNS = 3
"""Least number of runs from which the others define what is usual, given by arithmetic: one against
one is no majority."""


def rises(run: Run, names: Sequence[str]) -> FloatArray:
    """Return columns counted from their first reading, gaps interpolated, shape (rows, columns)."""
    filled = run.frame[list(names)].interpolate(limit_direction="both").to_numpy(dtype=np.float64)
    return np.asarray(filled - filled[0])


def warming(run: Run) -> FloatArray:
    """Return the mean rise of a run's thermometers in each row [K]; zeros if it has none."""
    if not run.temperatures:
        return np.zeros(len(run.frame))
    rise = rises(run, run.temperatures)
    rise = rise[:, np.isfinite(rise).all(axis=0)]
    return np.asarray(rise.mean(axis=1) if rise.size else np.zeros(len(rise)))
