"""How to treat any set of runs: choose the points and fit the error model."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from fmu_compensator.fit.data import Prepared, PreparedRun, moves
from fmu_compensator.fit.error_models import fitted_models
from fmu_compensator.fit.error_models.base import FittedModel, Task
from fmu_compensator.fit.error_models.options import refuse_unknown
from fmu_compensator.fit.points import GROUPINGS, Choice, choose_points, target_place
from fmu_compensator.fit.training import TrainingRun
from fmu_compensator.runtime.modelfile import INPUT_FORMS
from measurement.errors import BadInput, refuse_other, shown


@dataclass(frozen=True)
class Recipe:
    """How to get from prepared runs to a fitted error model.

    Attributes
    ----------
    kind : str
        Kind of the error model: a file in `fmu_compensator.fit.error_models`.
    points : {"grey", "hierarchical", "fuzzy", "all"} or names, optional
        The temperatures to use; by default the usual ones of the model's class.
    input_form : {"rise", "absolute", "level"}, optional
        By default the usual one of the model's class.
    grey : mapping
        Options of `choose_points`.
    options : mapping
        Options of the error model.
    speed : bool
        Whether the spindle speed is an input of the Gaussian, if every run has it.

    Raises
    ------
    BadInput
        For an unknown kind or form.
    """

    kind: str
    points: str | Sequence[str] = ""
    input_form: str = ""
    grey: Mapping[str, Any] = field(default_factory=dict)
    options: Mapping[str, Any] = field(default_factory=dict)
    speed: bool = True

    def __post_init__(self) -> None:
        """Check the names and fill in the defaults."""
        refuse_other("fit", "model", self.kind, fitted_models())
        for name, usual in (
            ("points", self.model.usual_points),
            ("input_form", self.model.usual_form),
        ):
            if getattr(self, name) is None or not len(getattr(self, name)):
                object.__setattr__(self, name, usual)
        refuse_other("fit", "input form", self.input_form, INPUT_FORMS)

    @property
    def model(self) -> type[FittedModel]:
        """The error model's class."""
        return fitted_models()[self.kind]

    def choose(self, prepared: Prepared, runs: Sequence[PreparedRun]) -> tuple[list[int], Any]:
        """Return the indices of the chosen sensors, and the choice for the provenance."""
        if all(run.lost for run in runs):
            raise BadInput("training runs", runs[0].name, f"{runs[0].lost}: leave out either")
        candidates = [index for index in prepared.candidates if moves(runs, index)]
        if self.points in ("all", *GROUPINGS) and not candidates:
            problem = "no temperature moves in most runs and is sound in all"
            raise BadInput("training runs", "", problem)
        if self.points == "all":
            return candidates, {}
        if isinstance(self.points, str) and self.points in GROUPINGS:
            settings: dict[str, Any] = {"grouping": self.points, "names": prepared.sensors}
            settings |= self.grey
            if settings.get("target") is not None:
                settings["target"] = target_place(prepared.targets, settings["target"], "fit")
            choice: Choice = choose_points(runs, candidates, **settings)
            return choice.chosen, choice.table(prepared.sensors)
        names = self.points.split(",") if isinstance(self.points, str) else list(self.points)
        names = list(dict.fromkeys(name.strip() for name in names))
        return prepared.readable([_index(name, prepared.sensors) for name in names]), {}

    def rows(self, run: PreparedRun, chosen: Sequence[int]) -> TrainingRun:
        """Return the rows of a run that the model uses."""
        return run.history(chosen) if self.model.history else run.complete(chosen)

    def task(self, prepared: Prepared, runs: Sequence[PreparedRun], chosen: Sequence[int]) -> Task:
        """Return the task to fit the model to."""
        names = [prepared.sensors[index] for index in chosen]
        rows = [self.rows(run, chosen) for run in runs]
        return Task(rows, names, prepared.targets, self.input_form)

    def fit(
        self, prepared: Prepared, runs: Sequence[PreparedRun], chosen: Sequence[int]
    ) -> FittedModel:
        """Return the fitted model."""
        refuse_unknown(self.kind, self.options, self.model.fit)
        return self.model.fit(self.task(prepared, runs, chosen), **self.options)


def _index(name: str, sensors: Sequence[str]) -> int:
    if name not in sensors:
        allowed = ", ".join([*GROUPINGS, "all"]) + ", or names of " + ", ".join(sensors)
        raise BadInput("fit", "points", f"{shown(name)} is not allowed: {allowed}")
    return list(sensors).index(name)
