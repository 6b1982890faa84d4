"""No mean function: the Gaussian, which every error model has, makes the whole prediction."""

from __future__ import annotations

from typing import Any, ClassVar

import numpy as np

from fmu_compensator.fit.error_models.base import FittedModel, Task
from fmu_compensator.fit.training import Array, TrainingRun


class NoMean(FittedModel):
    """Predicts zeros.

    Parameters
    ----------
    targets : int
        Number of targets.
    """

    title: ClassVar[str] = "One Gaussian"
    history: ClassVar[bool] = True
    usual_points: ClassVar[str] = "all"

    def __init__(self, targets: int) -> None:
        self._targets = targets

    @classmethod
    def fit(cls, task: Task) -> NoMean:
        """Return the model: there is nothing to fit."""
        return cls(len(task.target_names))

    def predict(self, run: TrainingRun, measured: Array | None = None) -> Array:
        """Return zeros."""
        return np.zeros((len(run.time_s), self._targets))

    def table(self) -> dict[str, Any]:
        """Return nothing: it has no numbers in the file."""
        return {}
