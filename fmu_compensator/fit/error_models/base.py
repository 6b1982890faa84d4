"""Base class of the error models for fitting."""

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
    """The data to fit a model to.

    Attributes
    ----------
    runs : sequence of TrainingRun
        The training runs.
    input_names, target_names : sequence of str
        Names of the columns of their inputs and targets.
    input_form : {"rise", "absolute", "level"}
        Form of the inputs.
    """

    runs: Sequence[TrainingRun]
    input_names: Sequence[str]
    target_names: Sequence[str]
    input_form: str


class FittedModel(ABC):
    """An error model with its numbers. Its twin in the runtime predicts.

    A subclass may predict whole runs at once if the result is the same to 1e-9.

    Attributes
    ----------
    title : str
        Name in tables and reports.
    history : bool
        Whether it remembers earlier samples; if so its runs are `PreparedRun.history`, else
        `PreparedRun.complete`.
    uses_measured : bool
        Whether it uses measured targets at run time.
    by_temperature : bool
        Whether it uses temperatures.
    usual_form, usual_points : str
        The default input form and points.
    notes : tuple of str
        What the fit left out, one line each.
    variants : mapping of str to (title, options)
        The same model with other options, as further rows of a comparison.
    """

    title: ClassVar[str] = ""
    history: ClassVar[bool] = False
    uses_measured: bool = False
    notes: tuple[str, ...] = ()
    by_temperature: ClassVar[bool] = True
    usual_form: ClassVar[str] = "rise"
    usual_points: ClassVar[str] = "grey"
    variants: ClassVar[Mapping[str, tuple[str, Mapping[str, Any]]]] = {}

    @classmethod
    def kind(cls) -> str:
        """Return its name in files and commands: that of its module."""
        return cls.__module__.rpartition(".")[2]

    @classmethod
    def takes_seed(cls) -> bool:
        """Return whether the fit starts at random, that is, has an option ``seed``."""
        return "seed" in signature(cls.fit).parameters

    @classmethod
    @abstractmethod
    def fit(cls, task: Task, *args: Any, **options: Any) -> FittedModel:
        """Return the model fitted to the task's runs.

        Parameters
        ----------
        task : Task
            The runs, and which of their columns are inputs and targets.
        **options
            Options of the model: the keyword-only parameters that it names in its signature.

        Raises
        ------
        BadInput
            If the data do not suffice for the model; one line that says why.
        """

    def predict(self, run: TrainingRun, measured: Array | None = None) -> Array:
        """Return the targets that the installed form predicts for a run, (n, m) [um, urad].

        Parameters
        ----------
        run : TrainingRun
            Only the number of its targets is used.
        measured : array (n, m), optional
            Readings of a displacement sensor, rows of NaN if not measured [um, urad].
            The prediction of a row may only use earlier rows.
        """
        fields, width = Fields(self.table(), self.kind()), run.inputs.shape[1]
        model = error_models()[self.kind()].from_fields(fields, width, run.targets.shape[1])
        return predicted(model, run, measured)

    @abstractmethod
    def table(self) -> dict[str, Any]:
        """Return the numbers for the compensator file, without ``kind`` and ``targets``."""

    def report(self) -> dict[str, Any]:
        """Return diagnostics of the fit for the file's provenance, in JSON types."""
        return {}


def predicted(model: ErrorModel, run: TrainingRun, measured: Array | None = None) -> Array:
    """Return the predictions of a new runtime model for a run, row by row, (n, m) [um, urad].

    Parameters
    ----------
    model : ErrorModel
    run, measured
        As in `FittedModel.predict`.
    """
    elapsed = np.diff(run.time_s, prepend=run.time_s[:1]).tolist()
    probed: list[list[float] | None] = [None] * len(elapsed)
    if measured is not None:
        probed[1:] = [row.tolist() if np.isfinite(row).all() else None for row in measured[:-1]]
    rows = zip(run.inputs.tolist(), elapsed, run.speed.tolist(), probed, strict=True)
    return np.array([model.predict(*row) for row in rows]).reshape(run.targets.shape)
