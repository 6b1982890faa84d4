"""No mean function: the Gaussian that stands on every error model does it all."""

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
        How many.
    """

    title: ClassVar[str] = "One Gaussian"
    history: ClassVar[bool] = True
    usual_points: ClassVar[str] = "all"

    def __init__(self, targets: int) -> None:
        self._targets = targets

    @classmethod
    def fit(cls, task: Task) -> NoMean:  # type: ignore[override]
        """Return the model: there is nothing to fit."""
        return cls(len(task.target_names))

    def predict(self, run: TrainingRun, measured: Array | None = None) -> Array:
        """Return zeros."""
        return np.zeros((len(run.time_s), self._targets))

    def table(self) -> dict[str, Any]:
        """Return nothing: the file holds no number of it."""
        return {}
