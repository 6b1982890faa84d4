"""What runs that a model never saw tell of it: how far to believe it, and where not."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, replace
from statistics import NormalDist
from typing import Any

import numpy as np

from fmu_compensator.fit.careful import CarefulModel
from fmu_compensator.fit.conditions import LIKE, UNLIKE, Fold, folds_of
from fmu_compensator.fit.data import Prepared, PreparedRun
from fmu_compensator.fit.error_models.base import FittedModel
from fmu_compensator.fit.intervals import COVERAGE, Residuals, quantiles
from fmu_compensator.fit.recipe import Recipe
from fmu_compensator.fit.training import Array

LEASH = 0.95
"""The error model may differ from the careful one as it does in this share of like samples [1]."""
KNOWN = 0.95
"""Inputs are known up to the novelty of this share of samples of runs like the training [1]."""
MOST_ROWS = 120
"""So many rows of a run tell as much as all [1]."""
DEVIATIONS = NormalDist().inv_cdf(0.5 + COVERAGE / 2.0)


@dataclass(frozen=True)
class Unseen:
    """One run, predicted by models that were fitted without it.

    Attributes
    ----------
    fold : Fold
        Which runs were left out together.
    run : str
        The run's name.
    hours : array (n,)
        Time since its start [h].
    measured, predicted, careful : arrays (n, m)
        Targets, the error model's prediction, and the careful model's [um, urad].
    novelty : array (n,)
        Of the inputs, to the careful model [1].
    """

    fold: Fold
    run: str
    hours: Array
    measured: Array
    predicted: Array
    careful: Array
    novelty: Array

    def held(self, leash: Array | None) -> Array:
        """Return the prediction on a leash; as it is without one."""
        if leash is None:
            return self.predicted
        return self.careful + np.clip(self.predicted - self.careful, -leash, leash)


def predict_unseen(
    recipe: Recipe,
    prepared: Prepared,
    on_step: Callable[[float], None] = lambda done: None,
    folds: Sequence[Fold] | None = None,
    pool: Executor | None = None,
) -> list[Unseen]:
    """Return every run left out, alone or with others of its condition, predicted by the rest.

    Parameters
    ----------
    recipe : Recipe
        Points are chosen anew in each fit: a choice that has seen the run would flatter it.
    prepared : Prepared
        The runs.
    on_step : callable
        Told after every fold which share of the work is done [1].
    folds : sequence of Fold, optional
        By default those of `folds_of`.
    pool : Executor, optional
        Fits the folds side by side; the answer is the same.
    """
    folds = folds_of(prepared.runs) if folds is None else folds
    by_out: dict[tuple[int, ...], list[Unseen]] = {}  # with few runs the same ones are left out
    different = list({fold.out: fold for fold in folds}.values())
    if pool is not None:
        waiting = [pool.submit(_left_out, recipe, prepared, fold) for fold in different]
    for number, fold in enumerate(different):
        answer = _left_out(recipe, prepared, fold) if pool is None else waiting[number].result()
        by_out[fold.out] = answer
        on_step((number + 1) / len(different))
    return [replace(one, fold=fold) for fold in folds for one in by_out[fold.out]]


def _left_out(recipe: Recipe, prepared: Prepared, fold: Fold) -> list[Unseen]:
    kept = [run for place, run in enumerate(prepared.runs) if place not in fold.out]
    chosen, _ = recipe.choose(prepared, kept)
    fitted = recipe.fit(prepared, kept, chosen)
    careful = CarefulModel.fit(kept, chosen, recipe.input_form)
    found = [unseen_run(fold, prepared.runs[place], fitted, careful, chosen) for place in fold.out]
    return [one for one in found if one is not None]


def unseen_run(
    fold: Fold,
    run: PreparedRun,
    fitted: FittedModel,
    careful: CarefulModel,
    chosen: Sequence[int],
    most_rows: int = MOST_ROWS,
) -> Unseen | None:
    """Return what models say of a run that they did not see; None for a run without targets."""
    rows = run.history(chosen)
    known = np.flatnonzero(rows.known)
    if not len(known):
        return None
    kept = known[:: max(len(known) // most_rows, 1)]
    safe, novelty = careful.predict(run, chosen)
    return Unseen(
        fold,
        run.name,
        (rows.time_s[kept] - rows.time_s[0]) / 3600.0,
        rows.targets[kept],
        fitted.predict(rows)[kept],
        safe[kept],
        novelty[kept],
    )


def leash_of(records: Sequence[Unseen]) -> Array:
    """Return how far the error model may be from the careful one, per target [um, urad]."""
    like = [one for one in records if one.fold.kind == LIKE]
    return quantiles([np.abs(one.predicted - one.careful) for one in like or records], LEASH)


def known_novelty(records: Sequence[Unseen]) -> float:
    """Return the novelty up to which inputs count as known [1]."""
    like = [one for one in records if one.fold.kind == LIKE]
    return float(quantiles([one.novelty[:, None] for one in like or records], KNOWN)[0])


def residuals_of(records: Sequence[Unseen], leash: Array | None) -> list[Residuals]:
    """Return what the leashed predictions missed."""
    return [
        Residuals(one.hours, one.measured - one.held(leash), one.novelty, one.fold.kind == UNLIKE)
        for one in records
    ]


def root_mean_squares(
    records: Sequence[Unseen], kind: str, leash: Array | None
) -> tuple[Array, Array] | None:
    """Return RMSE with the model and without, pooled over the runs of a kind of folds, each (m,).

    Every run counts as one. None where there is no such fold.
    """
    of_kind = [one for one in records if one.fold.kind == kind]
    if not of_kind:
        return None
    missed = [np.mean((one.measured - one.held(leash)) ** 2, axis=0) for one in of_kind]
    raw = [np.mean(one.measured**2, axis=0) for one in of_kind]
    return np.sqrt(np.mean(missed, axis=0)), np.sqrt(np.mean(raw, axis=0))


def promise(
    records: Sequence[Unseen], leash: Array | None, targets: Sequence[str]
) -> dict[str, Any]:
    """Return what was measured in like and in unlike conditions, for the provenance."""
    found: dict[str, Any] = {}
    for kind in (LIKE, UNLIKE):
        pooled = root_mean_squares(records, kind, leash)
        if pooled is None:
            continue
        found[kind] = {
            target: {"model": float(model), "no_model": float(none)}
            for target, model, none in zip(targets, *pooled, strict=True)
        }
        found[f"{kind}_folds"] = [
            {"left_out": name, "ratio_to_none": float(ratio)}
            for name, ratio in fold_ratios(records, leash).items()
            if any(one.fold.name == name and one.fold.kind == kind for one in records)
        ]
    return found


def fold_ratios(records: Sequence[Unseen], leash: Array | None) -> dict[str, float]:
    """Return for each fold the error over that of no compensation, mean over the targets [1].

    The mean is geometric, so that a target in um and one in urad count alike.
    """
    ratios: dict[str, float] = {}
    for name in dict.fromkeys(one.fold.name for one in records):
        here = [one for one in records if one.fold.name == name]
        missed = np.mean([np.mean((o.measured - o.held(leash)) ** 2, axis=0) for o in here], axis=0)
        raw = np.mean([np.mean(o.measured**2, axis=0) for o in here], axis=0)
        moved = raw > 0.0
        if moved.any():
            logs = np.log(np.maximum(missed[moved], 1e-12) / raw[moved])
            ratios[name] = float(np.exp(0.5 * logs.mean()))
    return ratios
