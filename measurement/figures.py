"""Figures of merit of predictions.

A pair of values counts only if neither is missing (NaN). A figure that the data do not define is
NaN.
"""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

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


def improvement(before: float, after: float) -> float:
    """Return "accuracy improved by": 1 - mean abs(after) / mean abs(before).

    Parameters
    ----------
    before, after : float
        The mean absolute error without and with compensation [unit].

    Returns
    -------
    float
        1 is perfect, 0 no gain, negative worse than no compensation; NaN if there was no error
        before.
    """
    return 1.0 - _ratio(after, before)


def _mean(values: npt.NDArray[np.float64]) -> float:
    return float(values.mean()) if values.size else math.nan


def _ratio(part: float, whole: float) -> float:
    return part / whole if whole > 0.0 else math.nan
