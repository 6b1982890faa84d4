"""Drift with the opposite sign of what a compensator learnt: a displacement flipped since then."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np
import pandas as pd

from fmu_compensator.fit.training import Array
from measurement.doubts.signs import is_opposite
from measurement.rig import AXES


def opposite_axes(drift: Array, error: Array) -> tuple[str, ...]:
    """Return the axes along which a run drifts opposite to the prediction.

    Parameters
    ----------
    drift, error : array (n, 3)
        Measured and remaining drift along X, Y, Z; NaN if unknown [um].
    """
    odd = []
    for place, axis in enumerate(AXES):
        known = np.isfinite(error[:, place])
        moved, left = drift[known, place], error[known, place]
        if is_opposite(moved, moved - left):
            odd.append(axis)
    return tuple(odd)


def opposite_columns(frame: pd.DataFrame) -> tuple[str, ...]:
    """Return the same from ``drift_X_um``, ``error_X_um`` ... of the measured axes."""
    drift, error = (
        frame.reindex(columns=[f"{what}_{axis}_um" for axis in AXES]).to_numpy(float)
        for what in ("drift", "error")
    )
    return opposite_axes(drift, error)


def sign_lines(found: Iterable[tuple[str, Sequence[str]]]) -> list[str]:
    """Return a line for each axis whose sign is doubtful.

    Parameters
    ----------
    found : iterable of (str, sequence of str)
        Runs, each with its `opposite_axes`.
    """
    found = list(found)
    by_axis = {axis: [name for name, axes in found if axis in axes] for axis in AXES}
    return [
        f"{axis} drifts with the opposite sign of what the compensator learnt in "
        f"{', '.join(names)}: is the displacement flipped there or in training?"
        for axis, names in by_axis.items()
        if names
    ]
