"""How the machine as a whole warms in a run: what doubts about units and places start from."""

from __future__ import annotations

import numpy as np

from measurement.resampling import FloatArray
from measurement.runs import Run

WARMS_K = 3.0
"""Less warming than this says nothing of a machine [K]."""


def warming(run: Run) -> FloatArray:
    """Return the mean rise of a run's thermometers over its rows [K]; zeros without any."""
    if not run.temperatures:
        return np.zeros(len(run.frame))
    filled = run.frame[run.temperatures].interpolate(limit_direction="both").to_numpy()
    filled = filled[:, np.isfinite(filled).all(axis=0)]
    return np.asarray((filled - filled[0]).mean(axis=1) if filled.size else np.zeros(len(filled)))
