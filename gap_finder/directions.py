"""Fewer columns that say the same: what is wrong in many parts at once moves few things.

A page has a thousand unknowns that nobody asks for: where each thermometer sits, how much each part
moves each axis, where each part starts. All are known to one standard deviation, so that any
rotation of them is as good a description; most rotated ones move nothing that is measured.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from plant_model.parameters import FloatArray

NEGLIGIBLE_SQUARES = 0.01
"""Squares that everything left out moves together at one standard deviation [tolerances^2]: a run
of a dozen channels that is within tolerance costs a thousand times as much. Set on no
data."""


def fewer(columns: Sequence[FloatArray]) -> list[FloatArray]:
    """Return columns in the directions that move something in any run.

    Parameters
    ----------
    columns : sequence of array, shape (N, Q) each
        The same unknowns' answers in several runs, for one standard deviation each; N may differ.

    Returns
    -------
    list of array, shape (N, q) each
        Answers to the same prior, less what moves all runs together by `NEGLIGIBLE_SQUARES`.
    """
    squares = sum((part.T @ part for part in columns), np.zeros((columns[0].shape[1],) * 2))
    size, directions = np.linalg.eigh(squares)
    kept = directions[:, np.cumsum(np.maximum(size, 0.0)) > NEGLIGIBLE_SQUARES]
    return [part @ kept for part in columns]
