"""What every error model can do when it is fitted."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from fmu_compensator.fit.training import Array, TrainingRun


@dataclass(frozen=True)
class Task:
    """What is to be fitted.

    Attributes
    ----------
    runs : sequence of TrainingRun
        The training runs.
    input_names, target_names : sequence of str
        Names of the columns of their inputs and targets.
    input_form : {"rise", "absolute"}
        What the inputs are.
    """

    runs: Sequence[TrainingRun]
    input_names: Sequence[str]
    target_names: Sequence[str]
    input_form: str


class FittedModel(ABC):
    """An error model with its numbers. Its twin in the runtime predicts the same to 1e-9."""

    @classmethod
    @abstractmethod
    def fit(cls, task: Task, **options: Any) -> FittedModel:
        """Return the model fitted to the task's runs.

        Raises
        ------
        BadInput
            When the data cannot carry the model; one line that says why.
        """

    @abstractmethod
    def predict(self, run: TrainingRun) -> Array:
        """Return the targets predicted for a run from its inputs, shape (n, m) [um, urad]."""

    @abstractmethod
    def table(self) -> dict[str, Any]:
        """Return the numbers for the compensator file, without ``kind`` and ``targets``."""

    def report(self) -> dict[str, Any]:
        """Return diagnostics of the fit for the file's provenance, as JSON can carry them."""
        return {}
