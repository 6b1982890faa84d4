"""Drift in proportion to the mean of the inputs, by least squares."""

from __future__ import annotations

from typing import Any

import numpy as np

from fmu_compensator.fit.error_models.base import FittedModel, Task
from fmu_compensator.fit.training import Array, TrainingRun


class FittedMeanRise(FittedModel):
    """y = b mean(x) with b = argmin sum (y - b mean(x))^2, one b per target."""

    title = "Mean rise"

    def __init__(self, slopes: Array) -> None:
        self.slopes = slopes

    @classmethod
    def fit(cls, task: Task, **options: Any) -> FittedMeanRise:
        """Return the model fitted to the task's runs."""
        mean = np.concatenate([run.inputs.mean(axis=1) for run in task.runs])
        targets = np.concatenate([run.targets for run in task.runs])
        return cls(mean @ targets / (mean @ mean))

    def predict(self, run: TrainingRun, measured: Array | None = None) -> Array:
        """Return the targets predicted for a run, shape (n, m)."""
        return np.asarray(run.inputs.mean(axis=1)[:, None] * self.slopes)

    def table(self) -> dict[str, Any]:
        """Return the numbers for the compensator file."""
        return {"slopes": self.slopes.tolist()}
