"""Gaussian-process regression with the covariance of all rows: no weights and no recursion."""

from dataclasses import dataclass, field
from typing import Self

import numpy as np
import numpy.typing as npt

from fmu_compensator.fit.features import Sample, with_lags

Array = npt.NDArray[np.float64]


@dataclass
class Dense:
    """All rows that were measured: rises, a walk of each run, and noise, which is the unit.

    *scale* is the prior variance of each feature's weight.
    """

    scale: Array
    walk: float
    runs: list[int] = field(default_factory=list)
    hours: list[float] = field(default_factory=list)
    leaps: list[float] = field(default_factory=list)
    features: list[Array] = field(default_factory=list)
    targets: list[Array] = field(default_factory=list)

    @classmethod
    def of(cls, scale: Array, walk: float, samples: list[Sample]) -> Self:
        found = cls(scale, walk)
        for run, one in enumerate(samples):
            for row in zip(one.hours, one.features, one.targets, strict=True):
                found.measured(run, *row)
        return found

    def measured(
        self, run: int, hour: float, features: Array, targets: Array, leap: float = 0.0
    ) -> None:
        self.runs.append(run)
        self.hours.append(hour)
        self.leaps.append(leap)
        self.features.append(features)
        self.targets.append(targets)

    def _with(self, run: int, hour: float, features: Array, leap: float) -> Array:
        walked = self.walk**2 * np.minimum(self.hours, hour) + np.minimum(self.leaps, leap)
        same = np.array(self.runs) == run
        return np.array(self.features) @ (self.scale * features) + np.where(same, walked, 0.0)

    @property
    def covariance(self) -> Array:
        rows = zip(self.runs, self.hours, self.features, self.leaps, strict=True)
        return np.array([self._with(*row) for row in rows]) + np.eye(len(self.runs))

    def predict(
        self, run: int, hour: float, features: Array, leap: float = 0.0
    ) -> tuple[Array, float]:
        """Return mean and variance of a new measurement."""
        mean, variance = np.zeros(np.shape(self.targets)[-1] if self.targets else 1), 0.0
        if self.runs:
            along = self._with(run, hour, features, leap)
            told = np.linalg.solve(self.covariance, along)
            mean, variance = told @ np.array(self.targets), -float(told @ along)
        prior = float(features @ (self.scale * features)) + self.walk**2 * hour + leap
        return mean, variance + prior + 1.0

    @property
    def noise(self) -> Array:
        """The most likely variance of each target's noise."""
        targets = np.array(self.targets)
        squares = np.einsum("ij,ij->j", targets, np.linalg.solve(self.covariance, targets))
        return np.asarray(squares / len(targets))

    def cost(self) -> float:
        """Return minus the log likelihood at the most likely sizes of the targets' noise."""
        determinant = np.linalg.slogdet(self.covariance)[1]
        fit = len(self.targets) * np.log(self.noise).sum()
        return float(0.5 * (len(self.noise) * determinant + fit))


LAGS_S = (900.0, 3600.0, 14400.0)


def drawn(
    seed: int,
    weights: Array,
    *,
    walk: float,
    noise: float = 1.0,
    rows: int = 20,
    step_s: float = 600.0,
    size: float = 1.0,
) -> Sample:
    """Return a run drawn from the model: rises of some sensors, walk and noise of two targets."""
    random = np.random.default_rng(seed)
    inputs, targets = len(weights) // (1 + len(LAGS_S)), weights.shape[1]
    time_s = step_s * np.arange(rows + 1)
    rises = np.cumsum(random.normal(0.3, 1.0, (rows + 1, inputs)), axis=0)
    rises -= rises[0]
    features = with_lags(time_s, rises)
    steps = np.sqrt(step_s / 3600.0) * random.standard_normal((rows, targets))
    bias = walk * size * np.cumsum(steps, axis=0)
    white = random.standard_normal((rows, targets))
    measured = features[1:] @ weights + noise * (bias + white)
    return Sample(time_s[1:] / 3600.0, features[1:], measured, np.zeros_like(measured))
