"""Fits an error model by itself to some runs, and prepares others for it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from fmu_compensator.fit.data import Prepared, PreparedRun, prepare
from fmu_compensator.fit.recipe import Recipe
from measurement.rig import Rig
from measurement.runs import Run


def learnt(
    recipe: Recipe | None, runs: Sequence[Run], judged: Sequence[Run], rig: Rig
) -> tuple[Prepared, list[PreparedRun], Any, list[int]]:
    """Return both sets of runs prepared, the fitted model, and the inputs that it uses.

    Without a recipe there is no model and no input.
    """
    form = recipe.input_form if recipe else "rise"
    train = prepare(runs, rig, form)
    unseen = prepare(judged, rig, form, sensors=train.sensors).runs
    if recipe is None:
        return train, unseen, None, []
    chosen, _ = recipe.choose(train, train.runs)
    return train, unseen, recipe.fit(train, train.runs, chosen), chosen
