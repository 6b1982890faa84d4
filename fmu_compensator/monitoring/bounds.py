"""Prediction bound and probability of a figure of a new run, given those of similar runs."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt
from scipy.special import stdtr, stdtrit

from measurement.resampling import WRONG


def upper_bound(values: Sequence[float]) -> float:
    r"""Return the largest figure expected of a further run like these.

    .. math:: \exp(m + t_{0.99,\,n - 1}\, s \sqrt{1 + 1/n})

    with m and s the mean and the standard deviation of the logarithms: the one-sided prediction
    bound of a log-normal figure, but at least the largest given figure. With fewer than two
    figures it is infinite, because their variation is unknown.
    """
    logs = _logs(values)
    if len(logs) < 2:
        return float("inf")
    mean, spread = _predictive(logs)
    beyond = float(stdtrit(len(logs) - 1, 1.0 - WRONG)) * spread
    return float(np.exp(max(mean + beyond, logs.max())))


def chance_of(figure: float, values: Sequence[float]) -> float:
    """Return the probability that a further run like these has this figure or a larger one [1].

    The distribution is that of `upper_bound`; 1 with fewer than two figures.

    Parameters
    ----------
    figure : float
        Above 0.
    values : sequence of float
        Figures of similar runs.
    """
    logs = _logs(values)
    if len(logs) < 2 or not figure > 0.0:
        return 1.0
    mean, spread = _predictive(logs)
    return float(stdtr(len(logs) - 1, (mean - np.log(figure)) / max(spread, 1e-12)))


def _logs(values: Sequence[float]) -> npt.NDArray[np.float64]:
    return np.log([value for value in values if np.isfinite(value) and value > 0.0])


def _predictive(logs: npt.NDArray[np.float64]) -> tuple[float, float]:
    """Return location and scale of the predictive distribution."""
    return float(logs.mean()), float(logs.std(ddof=1) * np.sqrt(1.0 + 1.0 / len(logs)))
