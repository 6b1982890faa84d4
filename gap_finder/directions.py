"""Reduces many columns to the few directions that change the measurements.

A page has a thousand nuisance unknowns: where each thermometer sits, how much each part moves each
axis, at which temperature each part starts. All are scaled to one standard deviation, so any
rotation of them describes the same prior; most of the rotated ones change nothing measurable.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from plant_model.parameters import FloatArray

NEGLIGIBLE_SQUARES = 0.01
"""Total squares of all dropped directions at one standard deviation [tolerances^2]: a run of a
dozen channels that is within tolerance costs a thousand times as much. Set on no data."""


def fewer(columns: Sequence[FloatArray]) -> list[FloatArray]:
    """Return columns in the directions that change something in any run.

    Parameters
    ----------
    columns : sequence of array, shape (N, Q) each
        Responses of several runs to one standard deviation of the same unknowns; N may differ.

    Returns
    -------
    list of array, shape (N, q) each
        Without the directions that together change all runs by at most `NEGLIGIBLE_SQUARES`.
    """
    squares = sum((part.T @ part for part in columns), np.zeros((columns[0].shape[1],) * 2))
    size, directions = np.linalg.eigh(squares)
    kept = directions[:, np.cumsum(np.maximum(size, 0.0)) > NEGLIGIBLE_SQUARES]
    return [part @ kept for part in columns]
