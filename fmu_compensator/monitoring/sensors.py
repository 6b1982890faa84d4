"""Checks whether the thermometers still agree with each other as they did in training."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np
from numpy.typing import NDArray
from scipy.special import stdtrit

from fmu_compensator.fit.data import bridged
from fmu_compensator.fit.features import MOST_ROWS
from fmu_compensator.fit.gaussian import DEGREES
from fmu_compensator.fit.installed import COVERAGE
from fmu_compensator.fit.training import Array
from fmu_compensator.runtime.modelfile import Model
from measurement.resampling import WRONG
from measurement.runs import Run

WORTH_SHARE = 1.0 - COVERAGE
"""A smaller share of a run does not justify a verdict [1], because an interval may miss as much: of
samples in which a thermometer is broken or astray, or of the shortest training run.
docs/lifecycle.md reports it."""
SMALLEST_K = 1.0
"""A thermometer that is off by less is not reported [K]: set on pieces of a spindle's runs and a
simulated jig borer, where below it other thermometers are off as well, and fewer are found."""


@dataclass(frozen=True)
class Astray:
    """A thermometer whose readings the others do not explain.

    Attributes
    ----------
    sensor : str
    off_by_K : float
        Deviation from its estimate by the others, not exceeded for most of the run [K].
    """

    sensor: str
    off_by_K: float  # noqa: N815


class Agreement:
    r"""The rises of all chosen sensors as the zero-mean Gaussian of the file.

    Sensor j deviates from its estimate by the others by :math:`(P r)_j / P_{jj}`, with variance
    :math:`g_j / P_{jj}` in runs left out of training. A sensor is astray if its deviation exceeds
    the limit from Student's t, and no other sensor's does without it.

    Parameters
    ----------
    model : Model
        A compensator; without a spare, the agreement of its sensors is unknown.
    """

    def __init__(self, model: Model) -> None:
        self._sensors = [model.sensors[index].name for index in model.chosen]
        table = model.table["spare"]
        self.is_known = table is not None and len(self._sensors) > 2
        if self.is_known:
            self._precision = np.array(table["precision"])
            self._growth = np.array(table["growth"])

    def of(self, run: Run) -> Astray | None:
        """Return the sensor that is astray in a run without broken readings; None if none."""
        rises = _rises(run, self._sensors) if self.is_known else None
        if rises is None:
            return None
        places = np.arange(len(self._sensors))
        off, limit = self._off(rises, places)
        if (off <= limit).all():
            return None
        worst = int(np.argmax(off / limit))
        rest_off, rest_limit = self._off(rises, np.delete(places, worst))
        if (rest_off > rest_limit).any():
            return None  # more than one sensor: the conditions are new
        return Astray(self._sensors[worst], float(off[worst]))

    def swapped(self, run: Run) -> tuple[str, str] | None:
        """Return two sensors with which all agree once they are exchanged, but not before.

        They must then agree better than all do without the worst: a sensor that is astray alone,
        exchanged for a like one, often agrees as well.
        """
        rises = _rises(run, self._sensors) if self.is_known else None
        if rises is None:
            return None
        shares = self._shares(rises, np.arange(len(self._sensors)))
        if shares.max() <= 1.0:
            return None
        rest = self._shares(rises, np.delete(np.arange(len(shares)), shares.argmax()))
        found: tuple[float, tuple[str, str] | None] = (min(rest.max(), 1.0), None)
        for first, second in combinations(range(len(self._sensors)), 2):
            turned = rises.copy()
            turned[:, [first, second]] = rises[:, [second, first]]
            worst = self._shares(turned, np.arange(len(shares))).max()
            if worst < found[0]:
                found = worst, (self._sensors[first], self._sensors[second])
        return found[1]

    def _shares(self, rises: Array, places: NDArray[np.int_]) -> Array:
        """Return the sensors' deviations as shares of their limits [1]."""
        off, limit = self._off(rises, places)
        return np.asarray(off / limit)

    def _off(self, rises: Array, places: NDArray[np.int_]) -> tuple[Array, Array]:
        """Return the sensors' deviations from their estimates by each other, and the limits [K]."""
        covariance = np.linalg.inv(self._precision)
        inverse = np.linalg.inv(covariance[np.ix_(places, places)])
        own = np.diag(inverse)
        off = np.quantile(np.abs(rises[:, places] @ inverse / own), 1.0 - WORTH_SHARE, axis=0)
        far = float(stdtrit(DEGREES, 1.0 - WRONG / (2.0 * len(places))))
        return off, np.maximum(far * np.sqrt(self._growth[places] / own), SMALLEST_K)


def swap_lines(found: Iterable[tuple[str, tuple[str, str] | None]]) -> list[str]:
    """Return a line for each pair of thermometers that may be swapped.

    Parameters
    ----------
    found : iterable of (str, pair of str or None)
        Runs, each with what `Agreement.swapped` returns.
    """
    runs_of: dict[tuple[str, str], list[str]] = {}
    for run, pair in found:
        if pair:
            runs_of.setdefault(pair, []).append(run)
    return [
        f"doubtful: {first} behaves like {second} in training, and that one like it, in "
        f"{', '.join(names)}: swapped there?"
        for (first, second), names in runs_of.items()
    ]


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
