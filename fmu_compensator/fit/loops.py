"""Lag and rate of the loop of drift over temperature, which arises because one lags the other.

When the spindle slows down, temperatures fall while the drift still grows, which no function of one
temperature can describe. The lag is the delay for which a straight line fits the drift best.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from fmu_compensator.fit.training import Array

MOST = 0.25
"""Lags up to this share of the shortest run are tried in either direction [1], the longest over
which correlations should be estimated: given by Box and Jenkins, Time Series Analysis, 2.1.6. The
fit is judged on the rest."""


@dataclass(frozen=True)
class Loop:
    """How the drift follows one temperature.

    Attributes
    ----------
    lag_min : float
        Delay of the drift after the temperature; below 0: the drift leads [min].
    is_limit : bool
        Whether the lag is the longest that the runs allow, so that the true one may be longer.
    rate : float
        Drift over rise at that lag [um/K, urad/K].
    open, closed : float
        Root mean square residual of a straight line of the rise, without and with the lag
        [um, urad].
    """

    lag_min: float
    is_limit: bool
    rate: float
    open: float
    closed: float


def loop_of(rises: Sequence[Array], drifts: Sequence[Array], step_s: float) -> Loop:
    """Return how the drift of some runs follows one temperature.

    Parameters
    ----------
    rises, drifts : sequence of array (n,)
        Run by run, evenly sampled from the start [K; um, urad].
    step_s : float
        Sampling interval [s].
    """
    most = int(MOST * min(len(rise) for rise in rises))
    # All lags are judged on the same samples. Before the start a rise is taken as constant, so only
    # the ends are left out, and the warm-up counts.
    drift = np.concatenate([drift_of_run[: len(drift_of_run) - most] for drift_of_run in drifts])
    padded = [np.concatenate([np.full(most, rise_of_run[0]), rise_of_run]) for rise_of_run in rises]
    by_lag = {}
    for lag in range(-most, most + 1):
        parts = [rise_of_run[most - lag : len(rise_of_run) - most - lag] for rise_of_run in padded]
        rise = np.concatenate(parts)
        away, off = rise - rise.mean(), drift - drift.mean()
        rate = float(away @ off) / max(float(away @ away), np.finfo(float).tiny)
        by_lag[lag] = float(np.sqrt(np.mean((off - rate * away) ** 2))), rate
    best = min(by_lag, key=lambda lag: by_lag[lag][0])
    rms, rate = by_lag[best]
    return Loop(best * step_s / 60.0, abs(best) == most, rate, by_lag[0][0], rms)
