"""Which error model a user gets who names none: judged where it has to go beyond its runs."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass
from typing import Any

import numpy as np

from fmu_compensator.fit.conditions import FEWEST_RUNS, folds_of
from fmu_compensator.fit.data import Prepared
from fmu_compensator.fit.recipe import Recipe
from fmu_compensator.fit.unseen import Unseen, fold_ratios, leash_of, predict_unseen
from measurement.errors import BadInput

CANDIDATES = ("mlr", "bayes", "ridge", "lasso", "arx", "ne", "gp", "thermal_states", "bp")
"""From the simplest on. `arma` needs measured drift, `fem` (and `vac`, which holds it) needs a
description of the spindle, and `ga_bp` is `bp` after a long search: name them with ``--model``."""
FALLBACK = "bayes"
"""Where there are too few runs to judge by."""
MOSTLY_HARD = 0.5
"""The harder half of the folds decides: close to the worst one, and not at the mercy of one [1]."""


@dataclass(frozen=True)
class JudgedModel:
    """One error model as it was judged.

    Attributes
    ----------
    recipe : Recipe
        How to fit it.
    records : list of Unseen
        Runs left out; empty where it could not be fitted, or too few runs were given.
    ratios : dict of str to float
        Error over that of no compensation by fold, the prediction on its leash [1].
    refusal : str
        Why it could not be fitted; empty if it could.
    """

    recipe: Recipe
    records: list[Unseen]
    ratios: dict[str, float]
    refusal: str = ""

    def score(self) -> float:
        """Return the mean logarithm of the ratios of the harder half of the folds."""
        return hard_score(list(self.ratios.values()))


@dataclass(frozen=True)
class Decision:
    """What was chosen, and among what.

    Attributes
    ----------
    chosen : JudgedModel
        The simplest within one standard error of the best.
    candidates : list of JudgedModel
        All of them.
    """

    chosen: JudgedModel
    candidates: list[JudgedModel]

    def table(self) -> list[dict[str, Any]]:
        """Return the judgement for the provenance: one row per candidate."""
        return [
            {
                "model": one.recipe.kind,
                "chosen": one is self.chosen,
                **(
                    {"refused": one.refusal}
                    if one.refusal
                    else {}
                    if not one.ratios
                    else {
                        "hard_folds": float(np.exp(one.score())),
                        "worst_fold": max(one.ratios.values()),
                        "ratio_to_none": one.ratios,
                    }
                ),
            }
            for one in self.candidates
        ]


def hard_score(ratios: Sequence[float]) -> float:
    """Return the mean logarithm of the larger half of some ratios."""
    logs = np.sort(np.log(np.maximum(ratios, 1e-9)))
    return float(np.mean(logs[int(len(logs) * (1.0 - MOSTLY_HARD)) :]))


def choose_model(
    prepare_form: Callable[[str], Prepared],
    recipe_of: Callable[[str], Recipe],
    candidates: Sequence[str] | None = None,
    on_step: Callable[[str, float], None] = lambda label, done: None,
    pool: Executor | None = None,
) -> Decision:
    """Return the error model to use.

    Parameters
    ----------
    prepare_form : callable
        Returns the prepared runs in an input form.
    recipe_of : callable
        Returns the recipe of a kind of error model.
    candidates : sequence of str, optional
        Kinds, from the simplest on; by default `CANDIDATES`.
    on_step : callable
        Told a candidate after each of its folds, and which share of all work is done [1].
    pool : Executor, optional
        Fits folds side by side.

    Raises
    ------
    BadInput
        If no candidate can be fitted, or none beats no compensation.

    Notes
    -----
    Judged is what would be installed: each model on its leash to the careful one. The folds leave
    out runs at the ends of conditions as well as runs like the rest. The score is the mean over
    the harder half of the folds; the simplest model whose folds are not worse than the best one's
    by more than one standard error of the difference is taken.
    """
    kinds = list(candidates or CANDIDATES)
    first = prepare_form(recipe_of(FALLBACK).input_form)
    if len(first.runs) < FEWEST_RUNS:
        only = JudgedModel(recipe_of(FALLBACK), [], {})
        return Decision(only, [only])
    folds = folds_of(first.runs)
    found: list[JudgedModel] = []
    for place, kind in enumerate(kinds):
        recipe = recipe_of(kind)

        def tell(done: float, place: int = place, kind: str = kind) -> None:
            on_step(kind, (place + done) / len(kinds))

        try:
            prepared = prepare_form(recipe.input_form)
            records = predict_unseen(recipe, prepared, tell, folds, pool)
        except BadInput as refusal:
            found.append(JudgedModel(recipe, [], {}, str(refusal)))
            continue
        found.append(JudgedModel(recipe, records, fold_ratios(records, leash_of(records))))
    judged = [one for one in found if one.ratios]
    if not judged:
        raise BadInput("fit", "model", f"no error model can be fitted: {found[0].refusal}")
    chosen = simplest_of_the_best(judged)
    if chosen.score() >= 0.0:
        ratio = float(np.exp(chosen.score()))
        raise BadInput(
            "training runs",
            "",
            f"no error model beats no compensation on runs left out ({chosen.recipe.kind}, the "
            f"best, leaves {100 * ratio:.0f} % of the drift in the harder half of the folds): "
            "record more runs, or name a --model to fit one all the same",
        )
    return Decision(chosen, found)


def simplest_of_the_best(judged: Sequence[JudgedModel]) -> JudgedModel:
    """Return the first candidate that is within one standard error of the best.

    The standard error is that of the mean difference by fold: folds are hard or easy for all.
    """
    best = min(judged, key=lambda one: one.score())
    for one in judged[: judged.index(best)]:
        shared = [name for name in one.ratios if name in best.ratios]
        if len(shared) < 2:
            continue
        apart = np.log([one.ratios[name] / best.ratios[name] for name in shared])
        error = float(np.std(apart, ddof=1) / np.sqrt(len(apart)))
        if one.score() - best.score() <= error and float(np.mean(apart)) <= error:
            return one
    return best
