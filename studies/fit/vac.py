"""Hybrid of other error models with weights by vector angle cosine, least squares, or condition."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any, ClassVar

import numpy as np
from scipy.optimize import nnls

from fmu_compensator.fit import error_models
from fmu_compensator.fit.error_models.base import FittedModel, Task
from fmu_compensator.fit.error_models.options import (
    FEWEST_ROWS,
    refuse_poor,
    refuse_unknown,
    within,
)
from fmu_compensator.fit.training import Array, TrainingRun
from measurement.errors import BadInput, refuse_other, shown
from measurement.spectrum import SAME_SPEED_SHARE, STILL_RPM
from studies.fit.by_run import FEWEST_TO_LEAVE_OUT
from studies.runtime.vac import CONDITIONS

COMBINATIONS = ("cosine", "least_squares", "adaptive")
STUDY = ("mlr", "ne", "fem")
WITHOUT_SPEED = ("mlr", "arx", "bp")
SETTLE_S, BLEND_S, MEMORY_S = 3600.0, 600.0, 3600.0
"""How long a change of speed counts, time constant of the weights, and how long an error is
remembered [s]: a judgement, set on no data."""


class VectorAngleCosine(FittedModel):
    """See its twin in the runtime for the equation.

    Parameters
    ----------
    kinds : sequence of str
        Kinds of the constituents.
    models : sequence of FittedModel
        The constituents, fitted.
    weights : dict of str to array (m, models)
        By condition [1].
    prior : array (m, models)
        Squared error of each constituent in training; empty unless adaptive [um^2, urad^2].
    diagnostics : dict
        For the report.
    """

    title = "VAC hybrid"
    variants: ClassVar[Mapping[str, tuple[str, Mapping[str, Any]]]] = {
        "vac_least_squares": ("VAC's least-squares twin", {"combination": "least_squares"}),
        "vac_adaptive": ("VAC with adaptive weights", {"combination": "adaptive"}),
    }
    history = True
    uses_measured = True

    def __init__(
        self,
        kinds: Sequence[str],
        models: Sequence[FittedModel],
        weights: dict[str, Array],
        prior: Array,
        diagnostics: dict[str, Any],
    ) -> None:
        self.kinds, self.models, self.weights, self.prior = kinds, models, weights, prior
        self._diagnostics = diagnostics
        self.uses_measured = bool(prior.size) or any(model.uses_measured for model in models)

    @classmethod
    def fit(
        cls,
        task: Task,
        *,
        models: Sequence[str] | str | None = None,
        combination: str = "cosine",
        held_out: bool = True,
        parts: Mapping[str, Mapping[str, Any]] | None = None,
        seed: int = 0,
    ) -> VectorAngleCosine:
        """Return the hybrid fitted to the task's runs.

        Parameters
        ----------
        task : Task
            Runs and names.
        models : sequence of str, optional
            Kinds of the constituents (or one text with commas); by default those of the study,
            mlr, ne and fem, or mlr, arx and bp if no speed was recorded.
        combination : {"cosine", "least_squares", "adaptive"}
            ``cosine``: the study's; non-negative weights with sum 1 and the largest cosine of the
            angle between prediction and measurement. It cannot detect a common factor by which all
            models are wrong. ``least_squares``: non-negative weights with the smallest sum of
            squared errors. ``adaptive``: separate least squares for each condition (standstill,
            speed just changed, steady), adapted by measurements if there are any.
        held_out : bool
            With at least three runs, weight the constituents by their predictions of runs that they
            were not fitted to. Otherwise an overfitted network would win.
        parts : mapping of str to mapping, optional
            Options of constituents by kind, such as ``{"ne": {"steady": "fem"}}``.
        seed : int
            Seed of constituents that take one.

        Raises
        ------
        BadInput
            For a value that is not allowed, or anything that a constituent refuses.
        """
        refuse_other("vac", "combination", combination, COMBINATIONS)
        refuse_poor(task)
        kinds = _constituents(models, task)
        within("vac", "seed", seed, 0, 2**31)
        given = _part_options(parts, kinds, seed)
        fitted = [_fitted(kind, task, given) for kind in kinds]
        use_held_out = held_out and len(task.runs) >= FEWEST_TO_LEAVE_OUT
        parts_of_runs = (
            _predicted_left_out(kinds, task, given)
            if use_held_out
            else [np.stack([model.predict(run) for model in fitted], 2) for run in task.runs]
        )
        rows = _Rows(task.runs, parts_of_runs)
        weights, prior = rows.combined(combination)
        diagnostics = {
            "models": list(kinds),
            "combination": combination,
            "judged_on_runs_left_out": use_held_out,
            "weights": {
                condition: {
                    name: dict(zip(kinds, np.round(row, 4).tolist(), strict=True))
                    for name, row in zip(task.target_names, weights[condition], strict=True)
                }
                for condition in (CONDITIONS if combination == "adaptive" else ("steady",))
            },
            "cosine": dict(zip(task.target_names, rows.cosines(weights["steady"]), strict=True)),
            "parts": {kind: part.report() for kind, part in zip(kinds, fitted, strict=True)},
        }
        return cls(kinds, fitted, weights, prior, diagnostics)

    def table(self) -> dict[str, Any]:
        """Return the numbers for the compensator file."""
        return {
            "models": [
                {"kind": kind, **model.table()}
                for kind, model in zip(self.kinds, self.models, strict=True)
            ],
            "weights": {name: self.weights[name].tolist() for name in CONDITIONS},
            "prior": self.prior.tolist(),
            "settle_s": SETTLE_S,
            "blend_s": BLEND_S,
            "memory_s": MEMORY_S,
        }

    def report(self) -> dict[str, Any]:
        """Return the weights, their cosine, and the reports of the constituents."""
        return self._diagnostics


class _Rows:
    """Measured and predicted rows of all runs, weighted by the time that they represent."""

    def __init__(self, runs: Sequence[TrainingRun], parts: Sequence[Array]) -> None:
        rows = [run.known for run in runs]
        root = np.sqrt(np.concatenate([r.weights[k] for r, k in zip(runs, rows, strict=True)]))
        self._weight = root**2
        self._parts = np.concatenate([p[k] for p, k in zip(parts, rows, strict=True)])
        self._x = root[:, None, None] * self._parts
        self._targets = np.concatenate([r.targets[k] for r, k in zip(runs, rows, strict=True)])
        self._y = root[:, None] * self._targets
        self._condition = np.concatenate(
            [conditions(r)[k] for r, k in zip(runs, rows, strict=True)]
        )

    def combined(self, combination: str) -> tuple[dict[str, Array], Array]:
        """Return the weights by condition, and the squared errors if they are to adapt."""
        targets, models = self._x.shape[1:]
        everywhere = np.array([self._solved(t, slice(None)) for t in range(targets)])
        if combination == "cosine":
            # The largest cosine over a cone is in the direction of the least-squares solution
            # there; it does not depend on the length, which is fixed by the sum of 1.
            everywhere = everywhere / everywhere.sum(axis=1, keepdims=True)
        weights = dict.fromkeys(CONDITIONS, everywhere)
        if combination != "adaptive":
            return weights, np.zeros((0, models))
        for number, name in enumerate(CONDITIONS):
            rows = self._condition == number
            if rows.sum() >= FEWEST_ROWS:  # else it uses the weights of all
                weights[name] = np.array([self._solved(t, rows) for t in range(targets)])
        missed = (self._targets[:, :, None] - self._parts) ** 2
        prior = np.average(missed, axis=0, weights=self._weight)
        return weights, np.maximum(prior, 1e-6)

    def _solved(self, target: int, rows: Any) -> Array:
        x, y = self._x[rows, target], self._y[rows, target]
        weights = nnls(x, y)[0]
        # If no model has the right direction, none is better than another.
        return np.asarray(weights) if weights.sum() > 0 else np.full(x.shape[1], 1 / x.shape[1])

    def cosines(self, weights: Array) -> list[float]:
        """Return the cosine of the angle between the hybrid and the measurement [1]."""
        cosines = []
        for target, row in enumerate(weights):
            yhat, y = self._x[:, target] @ row, self._y[:, target]
            size = np.linalg.norm(yhat) * np.linalg.norm(y)
            cosines.append(round(float(yhat @ y / size), 5) if size > 0 else 0.0)
        return cosines


def conditions(run: TrainingRun) -> np.ndarray[Any, np.dtype[np.intp]]:
    """Return the condition of every row, as an index of `CONDITIONS`."""
    states = np.zeros(len(run.time_s), dtype=np.intp)
    last, since = 0.0, 0.0
    for k, (elapsed, speed) in enumerate(
        zip(np.diff(run.time_s, prepend=run.time_s[0]), run.speed, strict=True)
    ):
        now = abs(float(speed)) if np.isfinite(speed) else last
        since = 0.0 if abs(now - last) > SAME_SPEED_SHARE * max(now, last) else since + elapsed
        last = now
        if now >= STILL_RPM:
            states[k] = 1 if since < SETTLE_S else 2
    return states


def _constituents(models: Sequence[str] | str | None, task: Task) -> tuple[str, ...]:
    allowed = [kind for kind in error_models.fitted_models() if kind != "vac"]
    if models is None:
        has_speed = all(np.isfinite(run.speed).any() for run in task.runs)
        usual = STUDY if has_speed else WITHOUT_SPEED
        return tuple(kind for kind in usual if kind in allowed)
    names = models.split(",") if isinstance(models, str) else list(models)
    for name in names:
        refuse_other("vac", "models", name, allowed)
    if not 2 <= len(set(names)) == len(names) <= 10:
        raise BadInput("vac", "models", "2 to 10 different models are needed")
    return tuple(names)


def _part_options(parts: Any, kinds: Sequence[str], seed: int) -> dict[str, dict[str, Any]]:
    """Return the options of every constituent.

    Raises
    ------
    BadInput
        If they are not a mapping by kind, or of a kind that is not a constituent.
    """
    if not isinstance(parts or {}, Mapping):
        raise BadInput("vac", "parts", f"{shown(parts)} is not allowed: options by model")
    models = error_models.fitted_models()
    options_by_kind: dict[str, dict[str, Any]] = {
        kind: {"seed": seed} if models[kind].takes_seed() else {} for kind in kinds
    }
    for kind, options in (parts or {}).items():
        if kind not in options_by_kind or not isinstance(options, Mapping):
            allowed = ", ".join(kinds)
            raise BadInput("vac", f"parts.{kind}", f"is not allowed: options of {allowed}")
        options_by_kind[kind] |= options
    return options_by_kind


def _fitted(kind: str, task: Task, options: Mapping[str, Mapping[str, Any]]) -> FittedModel:
    model = error_models.fitted_models()[kind]
    runs = task.runs if model.history else [run.at(run.known) for run in task.runs]
    refuse_unknown(kind, options[kind], model.fit)
    return model.fit(replace(task, runs=runs), **options[kind])


def _predicted_left_out(
    kinds: Sequence[str], task: Task, options: Mapping[str, Mapping[str, Any]]
) -> list[Array]:
    """Return each constituent's prediction of each run, fitted without it, (n, m, models)."""
    folds = FEWEST_TO_LEAVE_OUT
    parts: list[Array] = [np.zeros(0)] * len(task.runs)
    for fold in range(folds):
        others = [run for number, run in enumerate(task.runs) if number % folds != fold]
        fitted = [_fitted(kind, replace(task, runs=others), options) for kind in kinds]
        for number in range(fold, len(task.runs), folds):
            run = task.runs[number]
            parts[number] = np.stack([model.predict(run) for model in fitted], axis=2)
    return parts
