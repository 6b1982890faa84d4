"""How far a prediction may be off: conformal intervals with the run as the unit."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import product

import numpy as np

from fmu_compensator.fit.training import Array
from fmu_compensator.runtime.geometry import Geometry

COVERAGE = 0.9
FRESH_H = 0.25
"""An error of a run just started is that of a quarter of an hour [h]."""
POWERS = (0.0, 0.25, 0.5)
"""Ways in which an interval may grow with time [1]."""
PER_NOVELTY = (1.0, 2.0, 4.0)
"""Ways in which the error's variance may grow with novelty [1]. A Bayesian regression that is
right grows by 1; it never grows less, whatever the runs at hand say."""


@dataclass(frozen=True)
class Residuals:
    """What a model missed in a run that it was not fitted to.

    Attributes
    ----------
    hours : array (n,)
        Time since the run's start [h].
    values : array (n, m)
        Measured minus predicted [um, urad].
    novelty : array (n,), optional
        Of the inputs; zeros where it is not known [1].
    unlike : bool
        Whether no run of its condition was learnt from.
    """

    hours: Array
    values: Array
    novelty: Array = field(default_factory=lambda: np.zeros(1))
    unlike: bool = False


@dataclass(frozen=True)
class Interval:
    r"""Predictions are within plus and minus ``scale * grown``, the latter

    .. math:: (t_0 + t)^p \sqrt{1 + k h}

    with t the hours since the start and h the novelty of the inputs. An error of a model that
    starts right may wander off like a random walk (p = 1/2); that of a model that has seen all
    there is stays as large as it is (p = 0).

    Attributes
    ----------
    coverage : float
        Wanted share of samples within [1].
    power : float
        p [1].
    per_novelty : float
        k [1].
    scale : array (m,)
        Of each target [um or urad per h^p].
    longest_h : float
        The longest run that was looked at; later the width stays [h].
    runs : int
        How many runs it rests on.
    """

    coverage: float
    power: float
    per_novelty: float
    scale: Array
    longest_h: float
    runs: int

    def half_width(self, residuals: Residuals) -> Array:
        """Return the half width at each sample of a run, shape (n, m) [um, urad]."""
        return np.asarray(self.growth(residuals)[:, None] * self.scale)

    def growth(self, residuals: Residuals) -> Array:
        """Return the width over the scale at each sample of a run, shape (n,) [h^p]."""
        return _growth(residuals, self.power, self.per_novelty, self.longest_h)

    def within(self, residuals: Residuals) -> Array:
        """Return the share of samples that lie within, per target (m,) [1]."""
        inside = np.abs(residuals.values) <= self.half_width(residuals)
        return np.asarray(inside.mean(axis=0))


def _growth(residuals: Residuals, power: float, per_novelty: float, longest_h: float) -> Array:
    grown = (FRESH_H + np.minimum(residuals.hours, longest_h)) ** power
    return np.asarray(grown * np.sqrt(1.0 + per_novelty * residuals.novelty))


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
    01621459.2022.2060112). With nine runs or fewer that level is no level. Then it is the largest
    of the runs' own quantiles: of n + 1 runs, the further one is the worst in one case of n + 1.
    Runs of conditions that were learnt from and runs of others are looked at apart, and the wider
    interval counts: it is to hold in either. Of the ways to grow with time and with novelty, the
    one with the narrowest interval for that is taken.
    """
    if not runs:
        raise ValueError("no run is left to learn the interval from")
    longest = max(float(run.hours[-1]) for run in runs)
    new = any(run.novelty.any() for run in runs)
    found = []
    for power, per_novelty in product(POWERS, PER_NOVELTY if new else PER_NOVELTY[:1]):
        grown = [_growth(run, power, per_novelty, longest)[:, None] for run in runs]
        scale = np.max(
            [
                _scales(
                    [
                        np.abs(run.values) / size
                        for run, size in zip(runs, grown, strict=True)
                        if run.unlike == unlike
                    ],
                    coverage,
                )
                for unlike in {run.unlike for run in runs}
            ],
            axis=0,
        )
        found.append(Interval(coverage, power, per_novelty, scale, longest, len(runs)))
    return min(found, key=lambda interval: _mean_width(interval, runs))


def _mean_width(interval: Interval, runs: Sequence[Residuals]) -> float:
    """Return the mean logarithm of the targets' mean widths."""
    width = np.mean([interval.half_width(run).mean(axis=0) for run in runs], axis=0)
    return float(np.log(width[width > 0.0]).sum())


def _scales(scaled: Sequence[Array], coverage: float) -> Array:
    level = coverage * (1.0 + 1.0 / len(scaled))
    if level >= 1.0:
        return np.asarray(np.max([quantiles([one], coverage) for one in scaled], axis=0))
    return quantiles(scaled, level)


def quantiles(samples: Sequence[Array], level: float) -> Array:
    """Return each column's quantile of the mean of the runs' distributions, shape (m,).

    Parameters
    ----------
    samples : sequence of array (n, m)
        One per run; every run counts as one, whatever its rows.
    level : float
        Of the quantile [1].
    """
    weights = np.concatenate([np.full(len(one), 1.0 / len(one) / len(samples)) for one in samples])
    values = np.concatenate(list(samples))
    order = np.argsort(values, axis=0)
    place = [int(np.searchsorted(np.cumsum(weights[o]), level - 1e-12)) for o in order.T]
    rows = [order[min(at, len(order) - 1), k] for k, at in enumerate(place)]
    return np.asarray(values[rows, np.arange(values.shape[1])])


def axis_drift(geometry: Geometry, targets: Array, tool_length_mm: float) -> Array:
    """Return the tool tip's drift of every row, shape (n, 3) [um]."""
    return np.array([geometry.drift(row, tool_length_mm) for row in targets.tolist()])
