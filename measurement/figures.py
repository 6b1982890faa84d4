"""Figures of merit of predictions and compensations.

A pair of values counts only if neither is missing (NaN). A figure that the data do not define is
NaN.
"""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
import numpy.typing as npt
import pandas as pd

from measurement.rig import AXES, axis_of
from measurement.units import split_column

NEAR_ZERO_SHARE = 0.01
"""MAPE leaves out samples whose measured value is below this share of the largest one: a percentage
of almost zero is meaningless, and one such sample would outweigh all the others. Set on no data."""


def figures_of_merit(measured: npt.ArrayLike, predicted: npt.ArrayLike) -> dict[str, float]:
    """Return the figures of merit of a prediction; residual e = measured - predicted.

    Parameters
    ----------
    measured, predicted : array, same shape
        The measured quantity y and its prediction [unit].

    Returns
    -------
    dict
        ``max_abs``, ``min_abs``, ``mean_abs`` of the residual [unit]; ``rmse`` [unit]; ``r2`` =
        1 - sum e^2 / sum (y - mean y)^2 [1]; ``sse`` [unit^2]; ``mae`` [unit] (the same number as
        mean_abs, under the name of the hybrid-model study); ``mape`` = 100 mean abs(e/y) [%];
        ``mape_left_out``, the number of samples that MAPE leaves out as near zero [1]; ``eta``, the
        predictive ability 1 - sum abs(e) / sum abs(y) [1]; the number of ``samples`` used and of
        ``missing`` ones [1].

    Raises
    ------
    ValueError
        If the shapes differ or a value is infinite.
    """
    y, yhat = (np.asarray(values, dtype=np.float64) for values in (measured, predicted))
    if y.shape != yhat.shape:
        raise ValueError(f"measured has shape {y.shape} and predicted {yhat.shape}")
    y, yhat = y.ravel(), yhat.ravel()
    if np.isinf(y).any() or np.isinf(yhat).any():
        raise ValueError("a value is infinite")
    both = ~(np.isnan(y) | np.isnan(yhat))
    missing = int(both.size - both.sum())
    y, yhat = y[both], yhat[both]
    names = ("max_abs", "min_abs", "mean_abs", "rmse", "r2", "sse", "mae", "mape", "eta")
    if not y.size:
        counts = {"mape_left_out": 0.0, "samples": 0.0, "missing": float(missing)}
        return dict.fromkeys(names, math.nan) | counts
    error = np.abs(y - yhat)
    sse = float(np.sum(error**2))
    counted = (np.abs(y) >= NEAR_ZERO_SHARE * float(np.abs(y).max())) & (y != 0.0)
    return {
        "max_abs": float(error.max()),
        "min_abs": float(error.min()),
        "mean_abs": float(error.mean()),
        "rmse": math.sqrt(sse / y.size),
        # np.ptp first: rounding may shift the mean of equal values, and the sum is not quite 0.
        "r2": 1.0 - _ratio(sse, float(np.sum((y - y.mean()) ** 2)) if np.ptp(y) > 0.0 else 0.0),
        "sse": sse,
        "mae": float(error.mean()),
        "mape": 100.0 * _mean(error[counted] / np.abs(y[counted])),
        "eta": 1.0 - _ratio(float(error.sum()), float(np.abs(y).sum())),
        "mape_left_out": float(y.size - counted.sum()),
        "samples": float(y.size),
        "missing": float(missing),
    }


def improvement(before: npt.ArrayLike, after: npt.ArrayLike) -> float:
    """Return "accuracy improved by": 1 - mean abs(after) / mean abs(before).

    Parameters
    ----------
    before, after : float or array
        The error without and with compensation [unit]. If the arrays have the same shape, a sample
        counts only if both values are present; otherwise each array is averaged by itself.

    Returns
    -------
    float
        1 is perfect, 0 no gain, negative worse than no compensation; NaN if there was no error
        before.
    """
    first, second = (np.abs(np.asarray(values, dtype=np.float64)) for values in (before, after))
    if first.shape == second.shape:
        both = ~(np.isnan(first) | np.isnan(second))
        first, second = first[both], second[both]
    return 1.0 - _ratio(
        _mean(second[~np.isnan(second)]),
        _mean(first[~np.isnan(first)]),
    )


@dataclass(frozen=True)
class CompensationRow:
    """One axis of a compensation table.

    Attributes
    ----------
    axis : str
        X, Y or Z.
    before_max_um, before_mean_um, after_max_um, after_mean_um : float
        Largest and mean absolute drift, without and with compensation [um].
    improvement_percent : float
        Reduction of the mean [%].
    samples : int
        Number of samples that have both values.
    """

    axis: str
    before_max_um: float
    before_mean_um: float
    after_max_um: float
    after_mean_um: float
    improvement_percent: float
    samples: int

    def to_dict(self) -> dict[str, Any]:
        """Return the row as a plain dict."""
        return asdict(self)


def compensation_table(before: pd.DataFrame, after: pd.DataFrame) -> list[CompensationRow]:
    """Return, for each of X, Y and Z, the drift before and after compensation.

    Parameters
    ----------
    before, after : DataFrame, same number of rows
        One column per axis, whose name contains the axis: ``drift_X_um``, ``error_X_um``,
        ``disp_x_um`` or just ``X`` [um]. Columns that name no axis are ignored.

    Returns
    -------
    list of CompensationRow
        In the order X, Y, Z; an axis that neither frame has is left out.

    Raises
    ------
    ValueError
        If the frames differ in length, two columns name one axis, or only one frame has an axis.
    """
    if len(before) != len(after):
        raise ValueError(f"before has {len(before)} rows and after {len(after)}")
    first, second = _by_axis(before, "before"), _by_axis(after, "after")
    if set(first) != set(second):
        raise ValueError(f"before has the axes {sorted(first)} and after {sorted(second)}")
    return [_row(axis, first[axis], second[axis]) for axis in AXES if axis in first]


def _by_axis(frame: pd.DataFrame, what: str) -> dict[str, npt.NDArray[np.float64]]:
    columns: dict[str, npt.NDArray[np.float64]] = {}
    for name in map(str, frame.columns):
        try:
            signal, unit = split_column(name)
        except ValueError:
            signal, unit = name, "um"
        found = axis_of(signal) if unit == "um" else None
        if found is None:
            continue
        if found[0] in columns:
            raise ValueError(f"{what} has two columns for axis {found[0]}, one of them {name!r}")
        columns[found[0]] = frame[name].to_numpy(dtype=np.float64)
    return columns


def _row(
    axis: str, before: npt.NDArray[np.float64], after: npt.NDArray[np.float64]
) -> CompensationRow:
    both = ~(np.isnan(before) | np.isnan(after))
    first, second = np.abs(before[both]), np.abs(after[both])
    largest = [float(part.max()) if part.size else math.nan for part in (first, second)]
    return CompensationRow(
        axis,
        largest[0],
        _mean(first),
        largest[1],
        _mean(second),
        100.0 * improvement(first, second),
        int(both.sum()),
    )


def _mean(values: npt.NDArray[np.float64]) -> float:
    return float(values.mean()) if values.size else math.nan


def _ratio(part: float, whole: float) -> float:
    return part / whole if whole > 0.0 else math.nan
