"""How far a prediction may be off: conformal intervals with the run as the unit."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from fmu_compensator.fit.training import Array, TrainingRun
from fmu_compensator.runtime.geometry import AXES, Direct, Geometry

COVERAGE = 0.9
FRESH_H = 0.25
"""An error of a run just started is that of a quarter of an hour [h]."""
POWERS = (0.0, 0.25, 0.5)
"""Ways in which an interval may grow with time [1]."""


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
    r"""Predictions are within plus and minus ``scale * (FRESH_H + hours since the start)^power``.

    An error of a model that starts right may wander off like a random walk (power 1/2); that of a
    model that has seen all there is stays as large as it is (power 0).

    Attributes
    ----------
    coverage : float
        Wanted share of samples within [1].
    power : float
        How the width grows with time [1].
    scale : array (m,)
        Of each target [um or urad per h^power].
    longest_h : float
        The longest run that was looked at; later the width stays [h].
    runs : int
        How many runs it rests on.
    """

    coverage: float
    power: float
    scale: Array
    longest_h: float
    runs: int

    def half_width(self, hours: Array) -> Array:
        """Return the half width at times since the start, shape (n, m) [um, urad]."""
        grown = (FRESH_H + np.minimum(hours, self.longest_h)) ** self.power
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
    01621459.2022.2060112). With nine runs or fewer that level is no level. Then it is the largest
    of the runs' own quantiles: of n + 1 runs, the further one is the worst in one case of n + 1.
    Of the ways to grow, the one with the narrowest interval for that is taken.
    """
    if not runs:
        raise ValueError("no run is left to learn the interval from")
    longest = max(float(run.hours[-1]) for run in runs)
    found = [
        Interval(coverage, power, _scales(runs, coverage, power), longest, len(runs))
        for power in POWERS
    ]
    return min(found, key=lambda interval: _mean_width(interval, runs))


def _mean_width(interval: Interval, runs: Sequence[Residuals]) -> float:
    """Return the mean logarithm of the targets' mean widths."""
    width = np.mean([interval.half_width(run.hours).mean(axis=0) for run in runs], axis=0)
    return float(np.log(width[width > 0.0]).sum())


def _scales(runs: Sequence[Residuals], coverage: float, power: float) -> Array:
    scaled = [np.abs(run.values) / ((FRESH_H + run.hours) ** power)[:, None] for run in runs]
    if coverage * (1.0 + 1.0 / len(runs)) >= 1.0:
        return np.asarray(np.max([_quantiles([one], coverage) for one in scaled], axis=0))
    return _quantiles(scaled, coverage * (1.0 + 1.0 / len(runs)))


def _quantiles(scaled: Sequence[Array], level: float) -> Array:
    """Return each target's quantile of the mean of the runs' distributions."""
    weights = np.concatenate([np.full(len(one), 1.0 / len(one) / len(scaled)) for one in scaled])
    values = np.concatenate(list(scaled))
    order = np.argsort(values, axis=0)
    place = [int(np.searchsorted(np.cumsum(weights[o]), level - 1e-12)) for o in order.T]
    rows = [order[min(at, len(order) - 1), k] for k, at in enumerate(place)]
    return np.asarray(values[rows, np.arange(values.shape[1])])


def tool_tip_table(
    runs: Sequence[TrainingRun],
    predicted: Sequence[Array],
    geometry: Geometry,
    tool_length_mm: Sequence[float],
    coverage: float = COVERAGE,
) -> dict[str, Any]:
    """Return the compensator file's interval: of the tool tip's drift, in the machine's axes.

    Parameters
    ----------
    runs : sequence of TrainingRun
        Rows with targets.
    predicted : sequence of array (n, m)
        What a model that was fitted without the run predicts for its rows [um, urad].
    geometry : Geometry
        From targets to drift. Errors of tilt and radial drift go together, so their widths must
        not be added: it is the drift itself that the interval is learnt from.
    tool_length_mm : sequence of float
        Shortest and longest tool. In between, the run time takes the straight line; the spread of
        a sum that is linear in the length lies on or below it.
    coverage : float
        Wanted share of samples within [1].
    """
    residuals = [
        Residuals(
            (run.time_s - run.time_s[0]) / 3600.0,
            np.hstack(
                [
                    _drift(geometry, run.targets, length) - _drift(geometry, values, length)
                    for length in tool_length_mm
                ]
            ),
        )
        for run, values in zip(runs, predicted, strict=True)
    ]
    interval = conformal(residuals, coverage)
    measured = geometry.axes if isinstance(geometry, Direct) else AXES
    shortest, longest = (
        [
            float(f"{scale:.6g}") if axis in measured else None
            for axis, scale in zip(AXES, scales, strict=True)
        ]
        for scales in interval.scale.reshape(2, 3).tolist()
    )
    return {
        "coverage": coverage,
        "power": interval.power,
        "fresh_h": FRESH_H,
        "longest_h": float(f"{interval.longest_h:.6g}"),
        "shortest_tool_um": shortest,
        "longest_tool_um": longest,
    }


def _drift(geometry: Geometry, targets: Array, tool_length_mm: float) -> Array:
    """Return the tool tip's drift of every row, shape (n, 3) [um]."""
    return np.array([geometry.drift(row, tool_length_mm) for row in targets.tolist()])
