"""Checks whether the remaining drift is still within what the compensator promised."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt
from scipy.special import bdtr, stdtrit

from fmu_compensator.driving import Driven
from fmu_compensator.fit.installed import COVERAGE
from fmu_compensator.fit.promise import AxisLeft, left_of
from fmu_compensator.monitoring.bounds import chance_of, upper_bound
from measurement.rig import AXES


@dataclass(frozen=True)
class AxisError(AxisLeft):
    """The remaining error of one axis in one run.

    Attributes
    ----------
    axis : str
    bound : float
        Upper bound of the miss in a run like those in training [1].
    chance : float
        Probability of a miss this large or larger in a run like those in training [1].
    few : float
        Probability that an interval that keeps its promise holds so small a share [1]. Samples in a
        row on the same side of its edges count as one; NaN without an interval.
    gain : float
        Ratio of the measured to the predicted drift (least squares) [1].
    """

    axis: str
    bound: float
    chance: float
    few: float
    gain: float

    @property
    def is_unusual(self) -> bool:
        """Whether the miss is larger than a run like those in training should have."""
        return bool(self.miss > self.bound)


def misses_of(figures: Mapping[str, Any]) -> dict[str, list[float]]:
    """Return the misses of runs left out of training, by axis, from the file's figures."""
    runs = (figures.get("unseen") or {}).get("by_run") or []
    return {
        axis: [row["miss"][place] for row in runs if row["miss"][place] is not None]
        for place, axis in enumerate(AXES)
    }


def axis_errors(
    driven: Driven, misses: Mapping[str, Sequence[float]], promised: float
) -> list[AxisError]:
    """Return the error of each axis, except those with too few measurements.

    The bound is at least the promised half width, and equal to it if no misses are known.

    Parameters
    ----------
    driven : Driven
    misses : mapping of str to sequence of float
        Misses of runs left out of training, by axis [1].
    promised : float
        Share of samples that the interval should contain [1].
    """
    errors = []
    for axis, left in left_of(driven, "").axes.items():
        place = AXES.index(axis)
        known = np.isfinite(driven.error[:, place])
        drift, said = driven.drift[known, place], driven.predicted[known, place]
        size = float(said @ said)
        gain = float(said @ drift) / size if size > 0.0 else np.nan
        bound, chance = upper_bound(misses[axis]), chance_of(left.miss, misses[axis])
        bound = max(bound, 1.0) if np.isfinite(bound) else 1.0
        few = _few(np.abs(driven.error[known, place]) <= driven.half_width[known, place], promised)
        few = few if np.isfinite(left.inside) else np.nan
        errors.append(
            AxisError(**vars(left), axis=axis, bound=bound, chance=chance, few=few, gain=gain)
        )
    return errors


def _few(inside: npt.NDArray[np.bool_], promised: float) -> float:
    """Return the probability of this share of samples within the interval, or a smaller one."""
    pieces = 1 + int(np.sum(inside[1:] != inside[:-1]))
    return float(bdtr(round(inside.mean() * pieces), pieces, promised))


@dataclass(frozen=True)
class Gain:
    """Ratio of measured to predicted drift of an axis over several runs, with its range."""

    axis: str
    value: float
    low: float
    high: float


def gain_of(axis: str, runs: Sequence[AxisError]) -> Gain | None:
    """Return the mean gain of an axis and its 90 % range; None for fewer than two runs."""
    gains = np.array([error.gain for error in runs if np.isfinite(error.gain)])
    if len(gains) < 2:
        return None
    spread = float(gains.std(ddof=1)) / np.sqrt(len(gains))
    half = float(stdtrit(len(gains) - 1, 0.5 + COVERAGE / 2.0)) * spread
    mean = float(gains.mean())
    return Gain(axis, mean, mean - half, mean + half)
