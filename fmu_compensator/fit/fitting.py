"""From runs to a compensator file: points, error model, limits, provenance."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from contextlib import nullcontext
from functools import cache
from typing import Any

import numpy as np

from fmu_compensator.fit.choosing import choose_model
from fmu_compensator.fit.conditions import LIKE
from fmu_compensator.fit.data import Prepared, prepare
from fmu_compensator.fit.error_models.base import FittedModel
from fmu_compensator.fit.guarding import Guarding, guarding
from fmu_compensator.fit.ranges import limits_table, sensor_table
from fmu_compensator.fit.recipe import Recipe
from fmu_compensator.fit.remembered import remembered
from fmu_compensator.fit.spare import spare_table
from fmu_compensator.fit.training import Array, TrainingRun
from fmu_compensator.fit.unseen import Unseen, predict_unseen, promise
from fmu_compensator.runtime.fields import Fields
from fmu_compensator.runtime.geometry import FORMS, geometry_from_fields
from fmu_compensator.runtime.modelfile import FORMAT, KIND, model_text
from measurement.errors import BadInput, shown
from measurement.figures import figures_of_merit
from measurement.rig import FivePointRig, Rig
from measurement.runs import Run
from measurement.warm import cold_starts
from measurement.workers import workers

FIGURES = ("max_abs", "mean_abs", "rmse", "r2", "eta")


def fit_compensator(
    runs: Sequence[Run],
    rig: Rig,
    model: str | None = None,
    *,
    points: str | Sequence[str] | None = None,
    input_form: str | None = None,
    grey: Mapping[str, Any] | None = None,
    sensors: Sequence[str] | None = None,
    geometry_form: str = "rigid",
    tool_length_mm: tuple[float, float] | None = None,
    limits: Mapping[str, float] | None = None,
    leave_out_frozen: bool = True,
    name: str | None = None,
    title: str | None = None,
    created: str | None = None,
    candidates: Sequence[str] | None = None,
    keep_runs: bool = True,
    jobs: int = 1,
    on_step: Callable[[str, float], None] = lambda label, done: None,
    **model_options: Any,
) -> dict[str, Any]:
    """Fit a compensator to measured runs.

    Parameters
    ----------
    runs : sequence of Run
        The training runs. A run counts by its duration, whatever its sampling.
    rig : rig of `measurement.rig`
        What the displacement columns mean.
    model : str, optional
        Kind of error model: a file in `fmu_compensator.fit.error_models`. By default the simplest
        that is among the best on runs left out, conditions that it must go beyond included:
        `fmu_compensator.fit.choosing`.
    points : {"grey", "hierarchical", "fuzzy", "all"} or names, optional
        The temperatures to use: one per group of the grey, hierarchical or fuzzy clustering, every
        one that moves in every run, or those named (a sequence, or one text with commas). By
        default what is usual for the model.
    input_form : {"rise", "absolute", "level"}, optional
        ``rise``: temperatures and displacements are relative to their first valid sample. A
        sensor whose level jumps between runs then does no harm. ``absolute``: as read. ``level``:
        temperatures as read, displacements relative. By default what is usual for the model.
    grey : mapping, optional
        Options of `choose_points`: threshold, theta, image, absolute_image, score, and target by
        its name.
    sensors : sequence of str, optional
        The temperature inputs of the compensator; by default every temperature in the runs.
    geometry_form : {"rigid", "pure_rotation"}
        Of a five-point rig's geometry.
    tool_length_mm : tuple of float, optional
        Shortest and longest tool [mm].
    limits : mapping, optional
        ``offset_um``, ``slew_um_per_s``, ``hold_s``, ``recover_s`` where the defaults do not suit.
    leave_out_frozen : bool
        Do not use rows in which a displacement is frozen or saturated.
    name, title, created : str, optional
        For the file; *created* is a date (YYYY-MM-DD). No clock is read.
    candidates : sequence of str, optional
        Kinds to choose among where no *model* is named.
    keep_runs : bool
        Keep the runs, thinned, in the file, so that it can be updated without them:
        `fmu_compensator.fit.remembered`.
    jobs : int
        Processes that fit without some of the runs side by side; the file is the same.
    on_step : callable
        Told a model after each of its fits, and which share of the work is done [1].
    **model_options
        Options of the error model.

    Returns
    -------
    dict
        The compensator file's content, checked; `compensator_text` makes the file's text of it.
        Equal arguments give equal content.

    Raises
    ------
    BadInput
        One line that says what the data or the options lack.

    Notes
    -----
    Runs that are marked as begun warm are left out, unless all are, and a note says so.
    """
    runs, warm = cold_starts(runs)
    if points is not None and not len(points):
        raise BadInput(
            "fit", "points", "'' is not allowed: grey, hierarchical, fuzzy, all, or names"
        )
    if geometry_form not in FORMS:
        allowed = f"{shown(geometry_form)} is not allowed: {', '.join(FORMS)}"
        raise BadInput("fit", "geometry form", allowed)
    if model is None and model_options:
        name = next(iter(model_options))
        raise BadInput("fit", name, "an option needs a model to belong to: name one (--model)")

    @cache
    def prepare_form(form: str) -> Prepared:
        return prepare(runs, rig, form, sensors=sensors, leave_out_frozen=leave_out_frozen)

    def recipe_of(kind: str) -> Recipe:
        return Recipe(kind, points or "", input_form or "", dict(grey or {}), model_options)

    decision = None
    with workers(jobs) if jobs > 1 else nullcontext() as pool:
        if model is None:
            decision = choose_model(prepare_form, recipe_of, candidates, on_step, pool)
            recipe, records = decision.chosen.recipe, decision.chosen.records
        else:
            recipe = recipe_of(model)
            records = predict_unseen(
                recipe,
                prepare_form(recipe.input_form),
                lambda done: on_step(recipe.kind, done),
                pool=pool,
            )
    model, input_form = recipe.kind, recipe.input_form
    prepared = prepare_form(input_form)
    geometry_table = _geometry_table(rig, geometry_form)
    geometry = geometry_from_fields(Fields(geometry_table, "fit", "geometry"))
    chosen, choice = recipe.choose(prepared, prepared.runs)
    fitted = recipe.fit(prepared, prepared.runs, chosen)
    rows = [run.complete(chosen) for run in prepared.runs]
    limits_of = limits_table(geometry, rows, tool_length_mm, limits or {})
    around = guarding(
        prepared,
        chosen,
        input_form,
        [fitted.predict(run.history(chosen)) for run in prepared.runs],
        records,
        geometry,
        limits_of["tool_length_mm"],
    )
    named = recipe.points if isinstance(recipe.points, str) else list(recipe.points)
    options = {"points": named, "input_form": input_form, **recipe.grey, **model_options}
    table = {
        "format": FORMAT,
        "kind": KIND,
        "name": name or f"{model}_compensator",
        "title": title or f"{model} on {len(chosen)} temperatures, fitted to {_count(runs)}",
        "created": created,
        "sensors": [
            sensor_table(sensor, prepared.runs, index)
            for index, sensor in enumerate(prepared.sensors)
        ],
        "chosen": [prepared.sensors[index] for index in chosen],
        "input_form": input_form,
        "error_model": {"kind": model, "targets": list(geometry.targets), **fitted.table()},
        "geometry": geometry_table,
        "limits": limits_of,
        "interval": around.interval,
        "guard": around.guard,
        "correction": around.correction,
        "spare": spare_table(prepared.runs, chosen, fitted, geometry, limits_of["tool_length_mm"]),
        "provenance": {
            "runs": [
                {"name": run.name, "sha256": run.sha256, "rows": len(kept.time_s)}
                for run, kept in zip(runs, rows, strict=True)
            ],
            "notes": [*prepared.notes, *_dropped(prepared, rows), *([warm] if warm else [])],
            "options": _plain(options),
            "figures": _plain(
                {
                    "choice": choice,
                    "models": [] if decision is None else decision.table(),
                    "fit": fitted.report(),
                    "training": _figures(
                        prepared.targets,
                        rows,
                        [
                            predicted_known(fitted, recipe.rows(run, chosen))
                            for run in prepared.runs
                        ],
                    ),
                    "unseen": _unseen_figures(prepared.targets, records, around),
                }
            ),
        },
    }
    if keep_runs:
        table["training"] = remembered(runs, rig, prepared.sensors, leave_out_frozen)
    compensator_text(table)
    return table


def compensator_text(table: dict[str, Any]) -> str:
    """Return the compensator file's text, checked by the reader.

    Parameters
    ----------
    table : dict
        The file's content, of numbers, texts, lists and tables only.

    Raises
    ------
    BadInput
        If a field could not be read back, for example a name given by the caller.
    """
    try:
        return model_text(table)
    except ValueError as error:
        raise BadInput("fit", "", str(error)) from None


def predicted_known(fitted: FittedModel, run: TrainingRun) -> Array:
    """Return what a model predicts for the rows in which all targets were measured."""
    return fitted.predict(run)[run.known]


def _unseen_figures(
    targets: Sequence[str], records: Sequence[Unseen], found: Guarding
) -> dict[str, Any] | None:
    """Return what the predictions of runs left out are worth, for the provenance."""
    if not records:
        return None
    like = [one for one in records if one.fold.kind == LIKE]
    held = [one.held(found.leash) for one in like]
    interval = found.targets
    assert interval is not None
    return {
        **promise(records, found.leash, targets),
        "interval": {
            "coverage": interval.coverage,
            # Half width: scale times (fresh_h plus the hours since the start) to the power, times
            # the root of one plus per_novelty times the novelty.
            "scale": dict(zip(targets, interval.scale.tolist(), strict=True)),
            "power": interval.power,
            "per_novelty": interval.per_novelty,
            "longest_h": interval.longest_h,
        },
        "by_run": found.by_run,
        "rmse_by_run": [
            {
                "run": one.run,
                **_model_and_none(targets, _rms(one.measured - values), _rms(one.measured)),
            }
            for one, values in zip(like, held, strict=True)
        ],
    }


def _model_and_none(targets: Sequence[str], model: Array, none: Array) -> dict[str, Any]:
    return {
        target: {"model": float(one), "no_model": float(other)}
        for target, one, other in zip(targets, model, none, strict=True)
    }


def _rms(residual: Array) -> Array:
    return np.asarray(np.sqrt(np.mean(residual**2, axis=0)))


def _figures(
    targets: Sequence[str], rows: Sequence[TrainingRun], predicted: Sequence[Any]
) -> dict[str, Any]:
    """Return figures of merit per target, beside those of no model (a prediction of zero)."""
    measured = np.concatenate([run.targets for run in rows])
    values = np.concatenate(list(predicted))
    result = {}
    for number, target in enumerate(targets):
        y = measured[:, number]
        with_model = figures_of_merit(y, values[:, number])
        without = figures_of_merit(y, np.zeros_like(y))
        result[target] = {
            "model": {key: with_model[key] for key in FIGURES},
            "no_model": {key: without[key] for key in FIGURES},
        }
    return result


def _dropped(prepared: Prepared, rows: Sequence[TrainingRun]) -> list[str]:
    notes = []
    for run, kept in zip(prepared.runs, rows, strict=True):
        missing = int(run.usable.sum()) - len(kept.time_s)
        if missing:
            notes.append(f"{run.name}: {missing} rows left out, a value is missing in them")
    return notes


def _geometry_table(rig: Rig, form: str) -> dict[str, Any]:
    if isinstance(rig, FivePointRig):
        return {
            "kind": "five_point",
            "form": form,
            "near_to_gauge_mm": rig.near_to_gauge_mm,
            "spacing_mm": rig.spacing_mm,
        }
    axes = {name: {"axis": entry.axis, "sign": entry.sign} for name, entry in rig.axes.items()}
    return {"kind": "direct", "axes": axes}


def _count(runs: Sequence[Run]) -> str:
    return f"{len(runs)} run" + ("s" if len(runs) != 1 else "")


def _plain(value: Any) -> Any:
    """Return a value as JSON carries it: figures at 6 digits, what is undefined as null."""
    if isinstance(value, Mapping):
        return {str(key): _plain(entry) for key, entry in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(entry) for entry in value]
    if isinstance(value, float):
        return float(f"{value:.6g}") if math.isfinite(value) else None
    return value
