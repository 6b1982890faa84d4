"""How far a prediction may be off: conformal intervals with the run as the unit."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from fmu_compensator.fit.training import Array

COVERAGE = 0.9
FRESH_H = 0.25
"""An error of a run just started is that of a quarter of an hour [h]."""


@dataclass(frozen=True)
class Residuals:
    """What a model missed in a run that it was not fitted to.

    Attributes
    ----------
    hours : array (n,)
        Time since the run's start [h].
    values : array (n, m)
        Measured minus predicted [um, urad].
    """

    hours: Array
    values: Array


@dataclass(frozen=True)
class Interval:
    r"""Predictions are within plus and minus ``scale * sqrt(FRESH_H + hours since the start)``.

    An error of a model that starts right wanders off like a random walk.

    Attributes
    ----------
    coverage : float
        Wanted share of samples within [1].
    scale : array (m,)
        Of each target [um or urad per sqrt(h)].
    longest_h : float
        The longest run that was looked at; later the width stays [h].
    runs : int
        How many runs it rests on.
    """

    coverage: float
    scale: Array
    longest_h: float
    runs: int

    def half_width(self, hours: Array) -> Array:
        """Return the half width at times since the start, shape (n, m) [um, urad]."""
        grown = np.sqrt(FRESH_H + np.minimum(hours, self.longest_h))
        return np.asarray(grown[:, None] * self.scale)

    def within(self, residuals: Residuals) -> Array:
        """Return the share of samples that lie within, per target (m,) [1]."""
        inside = np.abs(residuals.values) <= self.half_width(residuals.hours)
        return np.asarray(inside.mean(axis=0))


def conformal(runs: Sequence[Residuals], coverage: float = COVERAGE) -> Interval:
    """Return the interval that runs left out tell.

    Parameters
    ----------
    runs : sequence of Residuals
        Each run's residuals, predicted by a model that was fitted without it.
    coverage : float
        Wanted share of samples of a further run within [1].

    Notes
    -----
    Samples of one run are not exchangeable, runs are. So the quantile is taken of the mean of the
    runs' empirical distributions of the scaled error, at ``coverage (1 + 1/runs)`` (pooled
    distribution functions, after Dunn, Wasserman and Ramdas (2023), doi:10.1080/
    01621459.2022.2060112). With few runs that level is beyond 1: the largest error counts then,
    and the coverage promised is not reached.
    """
    if not runs:
        raise ValueError("no run is left to learn the interval from")
    weights = np.concatenate([np.full(len(run.hours), 1.0 / len(run.hours)) for run in runs])
    weights /= weights.sum()
    scaled = np.concatenate(
        [np.abs(run.values) / np.sqrt(FRESH_H + run.hours)[:, None] for run in runs]
    )
    level = min(coverage * (1.0 + 1.0 / len(runs)), 1.0)
    scale = []
    for column in scaled.T:
        order = np.argsort(column)
        place = np.searchsorted(np.cumsum(weights[order]), level - 1e-12)
        scale.append(column[order[min(int(place), len(order) - 1)]])
    longest = max(float(run.hours[-1]) for run in runs)
    return Interval(coverage, np.array(scale), longest, len(runs))
