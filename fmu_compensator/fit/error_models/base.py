"""What every error model can do when it is fitted."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from inspect import signature
from typing import Any, ClassVar

import numpy as np

from fmu_compensator.fit.training import Array, TrainingRun
from fmu_compensator.runtime.error_models import error_models
from fmu_compensator.runtime.error_models.base import ErrorModel
from fmu_compensator.runtime.fields import Fields


@dataclass(frozen=True)
class Task:
    """What is to be fitted.

    Attributes
    ----------
    runs : sequence of TrainingRun
        The training runs.
    input_names, target_names : sequence of str
        Names of the columns of their inputs and targets.
    input_form : {"rise", "absolute", "level"}
        What the inputs are.
    """

    runs: Sequence[TrainingRun]
    input_names: Sequence[str]
    target_names: Sequence[str]
    input_form: str


class FittedModel(ABC):
    """An error model with its numbers. Its twin in the runtime predicts.

    A subclass may predict whole runs at once where that is the same to 1e-9.

    Attributes
    ----------
    title : str
        What tables and reports call it.
    history : bool
        Whether it remembers earlier samples; then its runs are `PreparedRun.history`, else
        `PreparedRun.complete`.
    uses_measured : bool
        Whether it gets better with measured targets at run time.
    by_temperature : bool
        Whether it takes temperatures in.
    usual_form, usual_points : str
        The input form, and the points to use, when the caller does not say.
    variants : mapping of str to (title, options)
        Rows of their own in a comparison: the same model with other options.
    """

    title: ClassVar[str] = ""
    history: ClassVar[bool] = False
    uses_measured: bool = False
    by_temperature: ClassVar[bool] = True
    usual_form: ClassVar[str] = "rise"
    usual_points: ClassVar[str] = "grey"
    variants: ClassVar[Mapping[str, tuple[str, Mapping[str, Any]]]] = {}

    @classmethod
    def kind(cls) -> str:
        """Return what files and commands call it: as its file."""
        return cls.__module__.rpartition(".")[2]

    @classmethod
    def takes_seed(cls) -> bool:
        """Return whether the fit starts at random: whether it has an option ``seed``."""
        return "seed" in signature(cls.fit).parameters

    @classmethod
    @abstractmethod
    def fit(cls, task: Task, **options: Any) -> FittedModel:
        """Return the model fitted to the task's runs.

        Parameters
        ----------
        task : Task
            The runs, and which of their columns are inputs and targets.
        **options
            The model's own; each names its options in its signature.

        Raises
        ------
        BadInput
            When the data cannot carry the model; one line that says why.
        """

    def predict(self, run: TrainingRun, measured: Array | None = None) -> Array:
        """Return the targets that the installed form predicts for a run, (n, m) [um, urad].

        Parameters
        ----------
        run : TrainingRun
            Of its targets only the number is looked at.
        measured : array (n, m), optional
            What a displacement sensor showed, rows of NaN where nothing was measured [um, urad].
            The prediction of a row may use the rows before it only.
        """
        fields, width = Fields(self.table(), self.kind()), run.inputs.shape[1]
        model = error_models()[self.kind()].from_fields(fields, width, run.targets.shape[1])
        return predicted(model, run, measured)

    @abstractmethod
    def table(self) -> dict[str, Any]:
        """Return the numbers for the compensator file, without ``kind`` and ``targets``."""

    def report(self) -> dict[str, Any]:
        """Return diagnostics of the fit for the file's provenance, as JSON can carry them."""
        return {}


def predicted(model: ErrorModel, run: TrainingRun, measured: Array | None = None) -> Array:
    """Return what a fresh model of the runtime predicts for a run, row by row, (n, m) [um, urad].

    Parameters
    ----------
    model : ErrorModel
    run, measured
        As `FittedModel.predict` has them.
    """
    elapsed = np.diff(run.time_s, prepend=run.time_s[:1]).tolist()
    told: list[list[float] | None] = [None] * len(elapsed)
    if measured is not None:
        told[1:] = [row.tolist() if np.isfinite(row).all() else None for row in measured[:-1]]
    rows = zip(run.inputs.tolist(), elapsed, run.speed.tolist(), told, strict=True)
    return np.array([model.predict(*row) for row in rows]).reshape(run.targets.shape)
