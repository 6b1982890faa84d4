"""Correlation of temperatures with the error, individually and in subsets."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np
import pandas as pd
from numpy.typing import NDArray

Array = NDArray[np.float64]
MOST_CANDIDATES = 12
"""Most inputs of which all subsets are tried: 4095 take a second. Set on no data."""


def pearson(series: Array, error: Array) -> Array:
    """Return Pearson's r between each column and the error; NaN if either is constant.

    Parameters
    ----------
    series : array (n, m)
        Temperatures [degC or K].
    error : array (n,)
        Error [um, urad].
    """
    return np.asarray(pd.DataFrame(series).corrwith(pd.Series(error)), dtype=np.float64)


@dataclass(frozen=True)
class Subset:
    """How well one combination of temperatures explains an error.

    Attributes
    ----------
    columns : tuple of int
        The temperatures.
    multiple_r : float
        R = sqrt(1 - SSE/SST) of the regression with a constant [1]. It never falls when a
        temperature is added, so it cannot be used to choose.
    r2_adjusted : float
        R2 with a penalty on every temperature [1].
    held_out_rmse : float
        RMS error of runs predicted by a regression on the other runs; NaN with one run [um, urad].
    """

    columns: tuple[int, ...]
    multiple_r: float
    r2_adjusted: float
    held_out_rmse: float


def all_subsets(runs: Sequence[tuple[Array, Array]]) -> list[Subset]:
    """Return every subset of the temperatures, 2^k - 1 of them, best adjusted R2 first.

    Parameters
    ----------
    runs : sequence of (series (n, k), error (n,))
        The runs' temperatures and error.

    Raises
    ------
    ValueError
        With more than 12 temperatures.
    """
    count = runs[0][0].shape[1]
    if not 1 <= count <= MOST_CANDIDATES:
        raise ValueError(f"{count} temperatures: 1 to {MOST_CANDIDATES} can be combined")
    # With a column of ones, each run's normal equations; a run is left out by subtracting its own.
    grams = [_normal_equations(series, error) for series, error in runs]
    total = sum(grams[1:], start=grams[0])
    y = np.concatenate([error for _, error in runs])
    sst = float(np.sum((y - y.mean()) ** 2))
    subsets = []
    for size in range(1, count + 1):
        for columns in combinations(range(count), size):
            places = [*columns, count]
            sse = _sse(total, _solved(total, places), places)
            r2 = 1.0 - sse / sst if sst > 0.0 else math.nan
            freedom = max(len(y) - size - 1, 1)
            adjusted = 1.0 - (1.0 - r2) * (len(y) - 1) / freedom
            multiple = math.sqrt(max(r2, 0.0))
            subsets.append(Subset(columns, multiple, adjusted, _held_out(grams, total, places, y)))
    return sorted(subsets, key=lambda subset: -subset.r2_adjusted)


def _normal_equations(series: Array, error: Array) -> Array:
    rows = np.column_stack([series, np.ones(len(series)), error])
    return np.asarray(rows.T @ rows)


def _solved(gram: Array, places: list[int]) -> Array:
    b = np.linalg.lstsq(gram[np.ix_(places, places)], gram[places, -1], rcond=None)[0]
    return np.asarray(b)


def _sse(gram: Array, b: Array, places: list[int]) -> float:
    inner = gram[np.ix_(places, places)]
    return max(float(gram[-1, -1] - 2.0 * b @ gram[places, -1] + b @ inner @ b), 0.0)


def _held_out(grams: Sequence[Array], total: Array, places: list[int], y: Array) -> float:
    if len(grams) < 2:
        return math.nan
    missed = sum(_sse(gram, _solved(total - gram, places), places) for gram in grams)
    return math.sqrt(missed / len(y))
