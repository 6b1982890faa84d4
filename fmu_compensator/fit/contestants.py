"""The contestants of a comparison: error models by name, their variants, and two baselines."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from fmu_compensator.fit.error_models import fitted_models
from fmu_compensator.fit.recipe import Recipe
from fmu_compensator.fit.training import Array, TrainingRun
from measurement.errors import BadInput, refuse_other, shown

NO_MODEL, PERSISTENCE = "no_model", "persistence"
BASELINES = {NO_MODEL: "No model (drift stays zero)", PERSISTENCE: "Persistence (last measured)"}
ONE_STEP = "_one_step"


@dataclass(frozen=True)
class Contestant:
    """One row of a comparison.

    Attributes
    ----------
    name, title : str
        For the table and the JSON form.
    recipe : Recipe or None
        How to fit it; None for a baseline.
    """

    name: str
    title: str
    recipe: Recipe | None


def contestants(
    names: Sequence[str] | None,
    *,
    points: str = "",
    seed: int | None = None,
    grey: Mapping[str, Any] | None = None,
    options: Mapping[str, Mapping[str, Any]] | None = None,
) -> list[Contestant]:
    """Return the baselines and the named models; by default all models and variants.

    Parameters
    ----------
    names : sequence of str, optional
        Kinds of error models, or names of their variants.
    points : str
        The points for all of them; empty: the usual ones of each.
    seed : int, optional
        For models that start at random.
    grey : mapping, optional
        Options of the choice of points.
    options : mapping of str to mapping, optional
        Options of the models, by the names above.

    Raises
    ------
    BadInput
        For a name that is unknown or given twice.
    """
    recipes: dict[str, tuple[str, str, Mapping[str, Any]]] = {
        name: (name, kind.title or name, {}) for name, kind in fitted_models().items()
    }
    for kind, model in fitted_models().items():
        variants = vars(model).get("variants", {})  # its own, not the inherited ones
        recipes |= {name: (kind, title, more) for name, (title, more) in variants.items()}
    chosen = list(recipes) if names is None else [name for name in names if name not in BASELINES]
    entries = [Contestant(name, title, None) for name, title in BASELINES.items()]
    for name in chosen:
        refuse_other("compare", "models", name, [*recipes, *BASELINES])
        if name in [other.name for other in entries]:
            raise BadInput("compare", "models", f"{shown(name)} is given twice")
        kind, title, own = recipes[name]
        more = {**own, **(options or {}).get(name, {})}
        if seed is not None and fitted_models()[kind].takes_seed():
            more["seed"] = seed
        recipe = Recipe(kind, points=points, grey=dict(grey or {}), options=more)
        entries.append(Contestant(name, title, recipe))
    for name in options or {}:
        if name not in chosen:
            raise BadInput("compare", "option", f"{shown(name)} does not take part")
    return entries


def held(run: TrainingRun, measured: Array | None) -> Array:
    """Return the prediction of persistence: the last measurement, zero before the first."""
    predicted = np.zeros_like(run.targets)
    if measured is None:
        return predicted
    last = np.zeros(run.targets.shape[1])
    for k in range(1, len(predicted)):
        if np.isfinite(measured[k - 1]).all():
            last = measured[k - 1]
        predicted[k] = last
    return predicted
