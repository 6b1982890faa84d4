"""What every error model can do when it is fitted."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from inspect import signature
from typing import Any, ClassVar

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
    input_form : {"rise", "absolute", "level"}
        What the inputs are.
    """

    runs: Sequence[TrainingRun]
    input_names: Sequence[str]
    target_names: Sequence[str]
    input_form: str


class FittedModel(ABC):
    """An error model with its numbers. Its twin in the runtime predicts the same to 1e-9.

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

    @abstractmethod
    def predict(self, run: TrainingRun, measured: Array | None = None) -> Array:
        """Return the targets predicted for a run from its inputs, shape (n, m) [um, urad].

        Parameters
        ----------
        run : TrainingRun
            Its targets are not looked at.
        measured : array (n, m), optional
            What a displacement sensor showed, rows of NaN where nothing was measured [um, urad].
            The prediction of a row may use the rows before it only.
        """

    @abstractmethod
    def table(self) -> dict[str, Any]:
        """Return the numbers for the compensator file, without ``kind`` and ``targets``."""

    def report(self) -> dict[str, Any]:
        """Return diagnostics of the fit for the file's provenance, as JSON can carry them."""
        return {}
