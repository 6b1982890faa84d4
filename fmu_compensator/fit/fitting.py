"""From runs to a compensator file: points, error model, limits, provenance."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import Executor
from contextlib import nullcontext
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from fmu_compensator.fit.conditions import Fold, folds_of
from fmu_compensator.fit.data import Prepared, left_out, prepare, speedless_notes
from fmu_compensator.fit.features import learnable
from fmu_compensator.fit.installed import Installed
from fmu_compensator.fit.promise import RunLeft, by_axis, judge_runs, leap_notes, promise
from fmu_compensator.fit.ranges import limits_table, sensor_table
from fmu_compensator.fit.recipe import Recipe
from fmu_compensator.fit.run_conditions import ranges_of
from fmu_compensator.fit.spare import spare_table
from fmu_compensator.fit.training import TrainingRun
from fmu_compensator.runtime.fields import Fields
from fmu_compensator.runtime.fmi_slave import taken_name
from fmu_compensator.runtime.geometry import FORMS, FivePoint, geometry_from_fields
from fmu_compensator.runtime.modelfile import FORMAT, KIND, model_text, parse_model
from measurement.doubts import doubt_lines
from measurement.errors import BadInput, counted, refuse_other
from measurement.faults import cleaned, find_faults, looked_over
from measurement.rig import FivePointRig, Rig
from measurement.runs import Run
from measurement.workers import one_thread, workers

USUAL_MODEL = "gaussian"


@one_thread()
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
    use_speed: bool = True,
    leave_out_frozen: bool = True,
    name: str | None = None,
    title: str | None = None,
    created: str | None = None,
    judge: bool = True,
    jobs: int = 1,
    on_step: Callable[[str, float], None] = lambda label, done: None,
    **model_options: Any,
) -> dict[str, Any]:
    """Fit a compensator to measured runs.

    Parameters
    ----------
    runs : sequence of Run
        The training runs. A run is weighted by its duration, whatever its sampling.
    rig : rig of `measurement.rig`
        Meaning of the displacement columns.
    model : str, optional
        Kind of error model: a file in `fmu_compensator.fit.error_models`, the mean function of the
        Gaussian. By default there is none: `fmu_compensator.fit.gaussian` predicts alone.
    points : {"grey", "hierarchical", "fuzzy", "all"} or names, optional
        The temperatures to use: one per group of the grey, hierarchical or fuzzy clustering, every
        one that moves in most runs, or those named; the default depends on the model.
    input_form : {"rise", "absolute", "level"}, optional
        ``rise``: temperatures and displacements are relative to their first valid sample, so that a
        sensor whose level jumps between runs does no harm. ``absolute``: as read. ``level``:
        temperatures as read, displacements relative. The default depends on the model.
    grey : mapping, optional
        Options of `choose_points`: threshold, theta, image, absolute_image, score, and the name of
        the target.
    sensors : sequence of str, optional
        The temperature inputs of the compensator; by default every temperature in the runs.
    geometry_form : {"rigid", "pure_rotation"}
        How a five-point rig's tilt moves the tool tip.
    tool_length_mm : tuple of float, optional
        Shortest and longest tool that the compensator may be used with [mm].
    limits : mapping of str to float, optional
        ``offset_um``, ``slew_um_per_s``, ``hold_s``, ``recover_s``, ``share`` to replace the
        defaults.
    use_speed : bool
        Use the spindle speed as an input of the Gaussian if every run has it. The compensator then
        needs it.
    leave_out_frozen : bool
        Leave out rows in which a displacement is frozen or saturated.
    name : str, optional
        Name in the file.
    title : str, optional
        Title in the file.
    created : str, optional
        Date in the file (YYYY-MM-DD); none by default, because no clock is read.
    judge : bool
        Leave runs and conditions out, to promise the remaining error there.
    jobs : int
        Number of processes for the fits without some of the runs; the file does not depend on it.
    on_step : callable
        Called after each fit with the model and the share of the work done [1].
    **model_options
        Options of the error model.

    Returns
    -------
    dict
        The compensator file's content, checked; `compensator_text` converts it to the file's text.
        Equal arguments give equal content.

    Raises
    ------
    BadInput
        One line that says what is wrong with the data or the options.

    Notes
    -----
    Runs marked as begun warm are left out, unless all are, and runs shorter than the shortest lag;
    notes say so.
    """
    given = runs
    runs, unused = learnable(given)
    if points is not None and not len(points):
        raise BadInput(
            "fit", "points", "'' is not allowed: grey, hierarchical, fuzzy, all, or names"
        )
    refuse_other("fit", "geometry form", geometry_form, FORMS)
    if model is None and model_options:
        name = next(iter(model_options))
        raise BadInput("fit", name, "an option needs a model to belong to: name one (--model)")
    recipe = Recipe(
        model or USUAL_MODEL,
        points or "",
        input_form or "",
        dict(grey or {}),
        model_options,
        use_speed,
    )
    runs = looked_over(runs)
    prepared = prepare(
        runs, rig, recipe.input_form, sensors=sensors, leave_out_frozen=leave_out_frozen
    )
    bench = _Bench(
        list(runs),
        prepared,
        rig,
        recipe,
        geometry_form,
        tool_length_mm,
        dict(limits or {}),
        leave_out_frozen,
    )
    everything = range(len(runs))
    installed, table = bench.table(everything)
    _check_names(table)
    folds = folds_of(prepared.runs) if judge else []
    with workers(jobs) if jobs > 1 and len(folds) > 1 else nullcontext() as pool:
        unseen = bench.left_out(folds, lambda done: on_step(recipe.kind, done), pool)
    training = bench.judged(table, everything) if judge else []
    rows = [run.complete(installed.chosen) for run in prepared.runs]
    named = recipe.points if isinstance(recipe.points, str) else list(recipe.points)
    options = {"points": named, "input_form": recipe.input_form, **recipe.grey, **model_options}
    table["name"] = name or f"{recipe.kind}_compensator"
    inputs = f"{len(installed.chosen)} temperatures{' and speed' * bool(installed.unit_rpm)}"
    fitted_to = f"fitted to {counted(len(runs), 'run')}"
    table["title"] = title or f"{recipe.kind} on {inputs}, {fitted_to}"
    table["created"] = created
    table["provenance"] = {
        "runs": [
            {"name": run.name, "sha256": run.fingerprint(table["chosen"]), "rows": len(kept.time_s)}
            for run, kept in zip(runs, rows, strict=True)
        ],
        "notes": [
            *doubt_lines(given),
            *prepared.notes,
            *_dropped(prepared, rows),
            *(speedless_notes(prepared) if recipe.speed else ()),
            *leap_notes(training),
            *installed.fitted.notes,
            *(_beyond(prepared, rig) if geometry_form == "pure_rotation" else ()),
            *unused,
        ],
        "options": as_json(options),
        "rig": rig.model_dump(mode="json"),
        "figures": as_json(
            {
                "choice": installed.choice,
                "fit": installed.fitted.report(),
                "training": by_axis(training),
                "conditions": ranges_of(runs, table["chosen"]),
                "unseen": promise(unseen),
            }
        ),
    }
    compensator_text(table)
    return table


@dataclass(frozen=True)
class _Bench:
    """Prepared runs, for fitting compensators to all of them or to some."""

    runs: list[Run]
    prepared: Prepared
    rig: Rig
    recipe: Recipe
    geometry_form: str
    tool_length_mm: tuple[float, float] | None
    limits: dict[str, float]
    leave_out_frozen: bool

    def table(self, places: Sequence[int]) -> tuple[Installed, dict[str, Any]]:
        """Return what is installed after fitting some runs, and its file without provenance."""
        prepared = self.prepared
        runs = [prepared.runs[place] for place in places]
        installed = Installed.fit(self.recipe, prepared, runs)
        chosen = installed.chosen
        geometry_table = _geometry_table(self.rig, self.geometry_form)
        geometry = geometry_from_fields(Fields(geometry_table, "fit", "geometry"))
        rows = [run.complete(chosen) for run in runs]
        error_model = installed.fitted.table()
        return installed, {
            "format": FORMAT,
            "kind": KIND,
            "name": "left_out",
            "title": "",
            "created": None,
            "sensors": [
                sensor_table(sensor, runs, index) for index, sensor in enumerate(prepared.sensors)
            ],
            "chosen": [prepared.sensors[index] for index in chosen],
            "input_form": self.recipe.input_form,
            "error_model": {
                "kind": self.recipe.kind,
                "targets": list(geometry.targets),
                **error_model,
            },
            "gaussian": installed.table(),
            "spare": spare_table(runs, installed),
            "geometry": geometry_table,
            "limits": limits_table(geometry, rows, self.tool_length_mm, self.limits),
            "provenance": {"runs": [], "notes": [], "options": {}, "figures": {}},
        }

    @cached_property
    def left(self) -> list[Run]:
        """The runs without their broken readings."""
        faults = find_faults(self.runs)
        return cleaned(self.runs, faults, left_out(self.leave_out_frozen))

    def left_out(
        self, folds: Sequence[Fold], on_step: Callable[[float], None], pool: Executor | None
    ) -> list[RunLeft]:
        """Return the remaining drift of left-out runs."""
        if folds:
            _ = self.left  # once, and not in each process
        different = list({fold.out: fold for fold in folds}.values())
        waiting = [pool.submit(self.of_fold, fold.out) for fold in different] if pool else []
        answers = {}
        for number, fold in enumerate(different):
            answers[fold.out] = waiting[number].result() if waiting else self.of_fold(fold.out)
            on_step((number + 1) / len(different))
        return [replace(record, fold=fold) for fold in folds for record in answers[fold.out]]

    def of_fold(self, out: Sequence[int]) -> list[RunLeft]:
        """Return the remaining drift of these runs with a compensator fitted to the others."""
        kept = [place for place in range(len(self.runs)) if place not in out]
        return self.judged(self.table(kept)[1], out)

    def judged(self, table: dict[str, Any], places: Sequence[int]) -> list[RunLeft]:
        """Return the remaining drift of some runs with a compensator."""
        model = parse_model(compensator_text(table), "fit")
        pairs = ((self.runs[place], self.left[place]) for place in places)
        return judge_runs(model, pairs, self.rig, model.limits.judged_tool())


def compensator_text(table: dict[str, Any]) -> str:
    """Return the compensator file's text, checked by the reader.

    Parameters
    ----------
    table : dict
        The file's content: numbers, texts, lists and tables only.

    Raises
    ------
    BadInput
        If a field could not be read back, for example a name given by the caller.
    """
    try:
        return model_text(table)
    except ValueError as error:
        raise BadInput("fit", "", str(error)) from None


def as_json(value: Any) -> Any:
    """Return a value in JSON types, with numbers of 6 digits and null for undefined ones.

    Parameters
    ----------
    value : object
        Number, text, or nested tables, lists and tuples of them.
    """
    if isinstance(value, Mapping):
        return {str(key): as_json(entry) for key, entry in value.items()}
    if isinstance(value, list | tuple):
        return [as_json(entry) for entry in value]
    if isinstance(value, float):
        return float(f"{value:.6g}") if math.isfinite(value) else None
    return value


def _dropped(prepared: Prepared, complete: Sequence[TrainingRun]) -> list[str]:
    notes, read, rows = [], 0, 0
    for run, kept in zip(prepared.runs, complete, strict=True):
        measured = run.usable & np.isfinite(run.targets).all(axis=1)
        used, known = len(kept.time_s), int(measured.sum())
        if used < known:
            notes.append(f"{run.name}: {used} of {known} rows used, the rest lack a temperature")
        read, rows = read + known, rows + int(run.usable.sum())
    if read < rows:  # a displacement is usually sampled less often on purpose
        notes.append(f"{read} of {rows} rows have all displacements: only these are learnt from")
    return notes


def _beyond(prepared: Prepared, rig: Rig) -> list[str]:
    """Return a note on what pure rotation neglects: the radial drift at the gauge line."""
    if not isinstance(rig, FivePointRig):
        return []
    rigid = FivePoint("rigid", rig.near_to_gauge_mm, rig.spacing_mm)
    poses = np.concatenate([run.targets[run.usable] for run in prepared.runs])
    drift = poses @ np.asarray(rigid.weights(0.0)[:2]).T
    x, y = np.sqrt(np.nanmean(drift**2, axis=0))
    return [
        "pure rotation leaves out the radial drift at the gauge line: "
        f"RMS X {x:.1f}, Y {y:.1f} um in training; --form rigid takes it in"
    ]


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


def _check_names(table: dict[str, Any]) -> None:
    """Refuse a thermometer whose name the compensator FMU needs for another variable."""
    taken = taken_name(parse_model(compensator_text(table), "fit"))
    if taken is not None:
        column = f"{taken}_degC"
        problem = f"the compensator FMU needs the name {taken!r}: rename the column in all runs"
        raise BadInput("fit", column, f"{problem}, e.g. {taken}_1_degC")
