"""Whether the thermometers still agree with each other as they did in training."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from fmu_compensator.fit.data import bridged
from fmu_compensator.fit.spare import MOST_ROWS, best_strength, precision
from fmu_compensator.fit.training import Array
from fmu_compensator.monitoring.bounds import RISK, upper_bound
from measurement.runs import Run

SHARE = 0.9
"""A run's distance is that which this share of its samples stays below [1]: a thermometer that
goes astray half-way counts."""
SMALLEST_K = 1.0
"""A thermometer that is off by less is not called broken [K]."""


@dataclass(frozen=True)
class Disagreement:
    """What one run's temperatures say, taken together.

    Attributes
    ----------
    distance, bound : float
        Of the temperatures from training, per sensor, and how large that may be [1].
    sensor : str or None
        The one thermometer without which the others are as in training; None where there is none.
    off_by_K : float
        How far it is from what the others say, at most times [K].
    """

    distance: float
    bound: float
    sensor: str | None = None
    off_by_K: float = 0.0  # noqa: N815


class Agreement:
    r"""The rises of all sensors as a Gaussian of mean zero, learnt from the training runs.

    The distance of a sample is :math:`r^T P r / k`; without sensor j it is
    :math:`(r^T P r - (P r)_j^2 / P_{jj}) / (k - 1)`, what is left if nothing is known of that one.
    Bounds come from training runs, each compared with the others.

    Parameters
    ----------
    runs : sequence of Run
        Training runs, broken readings left out.
    sensors : sequence of str
        Those that the compensator uses.
    """

    def __init__(self, runs: Sequence[Run], sensors: Sequence[str]) -> None:
        self._sensors = list(sensors)
        rises = [one for one in (_rises(run, sensors) for run in runs) if one is not None]
        self.is_known = len(rises) > 2 and len(self._sensors) > 2
        if not self.is_known:
            return
        strength = best_strength(rises)
        self._precision = precision(rises, strength)
        by_others = [
            precision([*rises[:at], *rises[at + 1 :]], strength) for at in range(len(rises))
        ]
        left_out = [_distances(*pair) for pair in zip(rises, by_others, strict=True)]
        self._bound = upper_bound([whole for whole, _ in left_out])
        places = range(len(self._sensors))
        self._without = [
            upper_bound([float(parts[sensor]) for _, parts in left_out]) for sensor in places
        ]
        missed = [_off_by(*pair) for pair in zip(rises, by_others, strict=True)]
        # One of many is to be blamed, so each must be the more unusual.
        risk = RISK / len(self._sensors)
        self._own = [
            max(upper_bound([float(one[sensor]) for one in missed], risk), SMALLEST_K)
            for sensor in places
        ]

    def of(self, run: Run) -> Disagreement | None:
        """Return how a run's temperatures agree, broken readings left out.

        None where they cannot be compared.
        """
        rises = _rises(run, self._sensors) if self.is_known else None
        if rises is None:
            return None
        distance, parts = _distances(rises, self._precision)
        if distance <= self._bound:
            return Disagreement(distance, self._bound)
        off_by = _off_by(rises, self._precision)
        fits = [
            sensor
            for sensor, rest in enumerate(parts)
            if rest <= self._without[sensor] and off_by[sensor] > self._own[sensor]
        ]
        if not fits:
            return Disagreement(distance, self._bound)
        best = min(fits, key=lambda sensor: parts[sensor])
        return Disagreement(distance, self._bound, self._sensors[best], float(off_by[best]))


def _off_by(rises: Array, known: Array) -> Array:
    """Return how far each sensor is from what the others say, shape (k,) [K]."""
    return np.asarray(np.quantile(np.abs(rises @ known / np.diag(known)), SHARE, axis=0))


def _distances(rises: Array, known: Array) -> tuple[float, Array]:
    """Return the distance of a run, and what is left of it without each sensor."""
    pulls = rises @ known
    whole = np.einsum("ij,ij->i", pulls, rises)
    parts = whole[:, None] - pulls**2 / np.diag(known)
    count = rises.shape[1]
    left = np.quantile(parts, SHARE, axis=0) / max(count - 1, 1)
    return float(np.quantile(whole, SHARE)) / count, np.asarray(left)


def _rises(run: Run, sensors: Sequence[str]) -> Array | None:
    """Return at most about `MOST_ROWS` rows of rises [K]."""
    names = [f"{name}_degC" for name in sensors]
    if any(name not in run.frame for name in names):
        return None
    columns = [bridged(run.time_s, run.frame[name].to_numpy(float)) for name in names]
    values = np.column_stack(columns)
    values = values[np.isfinite(values).all(axis=1)]
    if len(values) < 2:
        return None
    return np.asarray((values - values[0])[:: max(len(values) // MOST_ROWS, 1)])
