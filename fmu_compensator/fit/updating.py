"""Updates a compensator with new runs by conditioning its Gaussian; old runs are not needed."""

from __future__ import annotations

import copy
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from fmu_compensator.driving import learnt_as, refuse_lacking
from fmu_compensator.fit.data import Prepared, PreparedRun, left_out, prepare
from fmu_compensator.fit.error_models.base import predicted
from fmu_compensator.fit.features import Sample, sample_of, with_speed
from fmu_compensator.fit.gaussian import Gaussian, by_feature, directions
from fmu_compensator.fit.installed import listed, rises_of
from fmu_compensator.fit.promise import (
    FEWEST_JUDGED_ROWS,
    RunLeft,
    followed,
    judge_runs,
    leap_notes,
)
from fmu_compensator.fit.ranges import limits_table, sensor_table
from fmu_compensator.fit.run_conditions import NAMES, ranges_of
from fmu_compensator.fit.spare import spare_after
from fmu_compensator.fit.training import Array
from fmu_compensator.monitoring.sensors import Agreement, swap_lines
from fmu_compensator.runtime.modelfile import Model, model_text, parse_model
from fmu_compensator.signs import sign_lines
from measurement.doubts import doubt_lines
from measurement.errors import BadInput
from measurement.faults import cleaned, find_faults, looked_over
from measurement.rig import Rig, rig_from_table
from measurement.runs import Run
from measurement.warm import cold_starts
from measurement.workers import one_thread


@one_thread()
def update_compensator(
    model: Model, runs: Sequence[Run], *, created: str | None = None
) -> tuple[dict[str, Any], list[RunLeft]]:
    """Update a compensator with new runs.

    The error model and the Gaussian's scales stay. Its weights are conditioned on the new runs as
    they were on the old ones, so old runs are not needed; their uncertainty, the interval and what
    counts as new follow. The file's provenance records the remaining drift of the new runs with
    the old compensator, for which they were unseen. The promise is updated with the remaining drift
    of each new run after an update with the others; a single new run is judged with the old
    compensator. Runs marked as begun warm are left out, unless all are, and a note says so.

    Parameters
    ----------
    model : Model
        A compensator file.
    runs : sequence of Run
        New runs, with the same thermometers and displacements.
    created : str, optional
        Date for the file (YYYY-MM-DD).

    Returns
    -------
    table : dict
        The new file's content, checked.
    before : list of RunLeft
        Remaining drift of the new runs with the old compensator.

    Raises
    ------
    BadInput
        If the file does not contain its rig, a new run is an old one, or a column is missing.
    """
    rig = _rig(model)
    _check_new(model, runs, rig)
    runs, warm = cold_starts(runs)
    names = [sensor.name for sensor in model.sensors]
    runs = looked_over(runs)
    prepared = prepare(runs, rig, model.input_form, sensors=names)
    chosen = _places(model, prepared)
    left = cleaned(runs, find_faults(runs), left_out(frozen=True))
    pairs = list(zip(runs, left, strict=True))
    before = judge_runs(model, pairs, rig, model.limits.judged_tool())
    table = _taken_in(model, prepared, chosen, range(len(runs)))
    provenance = table["provenance"]
    rows = [int(run.complete(chosen).known.sum()) for run in prepared.runs]
    provenance["runs"] += [
        {"name": run.name, "sha256": run.fingerprint(table["chosen"]), "rows": count}
        for run, count in zip(runs, rows, strict=True)
    ]
    agreement = Agreement(model)
    notes = [
        *doubt_lines(runs),
        *sign_lines((record.run, record.opposite) for record in before),
        *swap_lines((run.name, agreement.swapped(run)) for _, run in pairs),
        *prepared.notes,
        *leap_notes(before),
        *([warm] if warm else []),
    ]
    provenance["notes"] += [note for note in notes if note not in provenance["notes"]]
    figures = provenance["figures"]
    used = [model.sensors[index].name for index in model.chosen]
    unseen = before if len(runs) == 1 else _unseen(model, prepared, chosen, pairs)
    ranges = figures.get("conditions") or ()
    figures["unseen"] = followed(figures.get("unseen"), _counted(unseen, runs, ranges))
    figures["conditions"] = _together(ranges, ranges_of(runs, used))
    figures["updated"] = [*figures.get("updated", ()), *(_listed_left(record) for record in before)]
    table["created"] = created
    return table, before


def _rig(model: Model) -> Rig:
    if "rig" not in model.provenance:
        problem = "is missing: fit it anew with all runs"
        raise BadInput(model.source, "provenance.rig", problem)
    return rig_from_table(model.provenance["rig"], f"{model.source}: provenance.rig")


def _check_new(model: Model, runs: Sequence[Run], rig: Rig) -> None:
    names = model.provenance["runs"]
    # An update keeps the scales, and a single run does not show how runs differ: on the simulated
    # jig borer, updating such a fit was worse than not updating it.
    if len(names) < 2:
        problem = f"{len(names)} run stands behind it, too few for its scales: fit all runs anew"
        raise BadInput(model.source, "provenance.runs", problem)
    for run in runs:
        if (name := learnt_as(model, run)) is not None:
            problem = f"is already in the compensator, as {name}"
            raise BadInput(run.path or run.name, "", problem)
        refuse_lacking(model, run)
        lost = next((name for name in rig.columns if name not in run.frame), None)
        if lost is not None:
            problem = "is missing, and the compensator was fitted with it"
            raise BadInput(run.path or run.name, f"column {lost}", problem)


def _places(model: Model, prepared: Prepared) -> list[int]:
    """Return the places of the compensator's thermometers among the runs'.

    Raises
    ------
    BadInput
        If one is not available, or a run has no row with all of them and all displacements.
    """
    used = [model.sensors[index].name for index in model.chosen]
    for name in used:
        if name not in prepared.sensors:
            why = next(note for note in prepared.notes if note.startswith(f"{name} is left out: "))
            problem = f"{why.partition(': ')[2]}, and the compensator uses it: leave such runs out"
            raise BadInput("update", name, problem)
    chosen = [prepared.sensors.index(name) for name in used]
    for run in prepared.runs:
        if run.complete(chosen).known.sum() < FEWEST_JUDGED_ROWS:
            problem = run.lost or (
                f"has fewer than {FEWEST_JUDGED_ROWS} rows with all displacements and all "
                "thermometers in use"
            )
            raise BadInput("update", run.name, f"{problem}: nothing can be learnt from it")
    return chosen


def _taken_in(
    model: Model, prepared: Prepared, chosen: Sequence[int], places: Iterable[int]
) -> dict[str, Any]:
    """Return the file's content after an update with some of the new runs."""
    table = copy.deepcopy(model.table)
    runs = [prepared.runs[place] for place in places]
    _condition(table["gaussian"], [sample_of_run(model, run, chosen) for run in runs])
    _widen(table, model, runs, prepared.sensors, chosen)
    if table["spare"] is not None:
        before = len(model.provenance["runs"])
        table["spare"] = spare_after(table["spare"], runs, chosen, before)
    return table


def _unseen(
    model: Model, prepared: Prepared, chosen: Sequence[int], pairs: Sequence[tuple[Run, Run]]
) -> list[RunLeft]:
    """Return the remaining drift of each new run after an update with the others."""
    rig, judged = _rig(model), []
    for place, pair in enumerate(pairs):
        others = [other for other in range(len(pairs)) if other != place]
        table = _taken_in(model, prepared, chosen, others)
        without = parse_model(model_text(table), model.source)
        judged += judge_runs(without, [pair], rig, model.limits.judged_tool())
    return judged


def _counted(
    records: Sequence[RunLeft], runs: Sequence[Run], conditions: Sequence[Sequence[float] | None]
) -> list[RunLeft]:
    """Return the remaining drift of runs with a reduced count for those that ended early."""
    ranges = dict(zip((name for name, _ in NAMES), conditions, strict=False))
    shortest_h = (ranges.get("duration") or (0.0,))[0]
    hours = [float(np.ptp(run.time_s)) / 3600.0 for run in runs]
    return [
        replace(record, counts=min(1.0, lasted / shortest_h)) if shortest_h else record
        for record, lasted in zip(records, hours, strict=True)
    ]


def sample_of_run(model: Model, run: PreparedRun, chosen: Sequence[int]) -> Sample:
    """Return the rows of a new run to learn the weights from.

    Parameters
    ----------
    model : Model
    run : PreparedRun
        The new run.
    chosen : sequence of int
        Places of the compensator's sensors among the run's.
    """
    table = model.table["gaussian"]
    rows = run.history(chosen)
    targets = rows.targets - np.array(table["constant"])
    usual = np.array(table["usual"]) if "usual" in table else None
    rises, mean = rises_of(run, rows, chosen, usual), predicted(model.new_error_model(), rows)
    inputs = with_speed(rows, rises, table.get("speed_rpm"))
    return sample_of(rows, inputs, targets, mean, table["settled_h"])


def gaussian_of(table: Mapping[str, Any]) -> Gaussian:
    """Return the model of a file's table ``gaussian``.

    Parameters
    ----------
    table : mapping

    Raises
    ------
    BadInput
        If it leaves nothing to be learnt.
    """
    seen, scale, noise = _seen(table), np.array(table["scale"]), np.array(table["noise"])
    covariance = np.diag(by_feature(scale, seen.shape[1])) - seen.T @ seen
    if not np.linalg.eigvalsh(covariance)[0] > 0.0:
        problem = "leaves no variance above 0 beside `seen`: fit it anew with all runs"
        raise BadInput("compensator file", "gaussian.scale", problem)
    return Gaussian(
        np.array(table["weights"]).T,
        covariance,
        scale,
        float(np.sqrt(table["walk_per_h"])),
        noise @ noise.T,
        table["rows"],
        np.array(table.get("mean_share", [1.0] * len(table["constant"]))),
    )


def _seen(table: Mapping[str, Any]) -> Array:
    return np.array(table["seen"]).reshape(-1, len(table["weights"][0]))


def _condition(table: dict[str, Any], samples: Sequence[Sample]) -> None:
    """Condition the Gaussian of a file's table on further runs."""
    after = gaussian_of(table).updated([sample for sample in samples if len(sample.hours)])
    table["weights"] = listed(after.weights.T)
    table["seen"] = listed(directions(after, samples, _seen(table)), digits=12)
    table["noise"] = listed(np.linalg.cholesky(after.spread))
    table["rows"] = after.rows


def _widen(
    table: dict[str, Any],
    model: Model,
    runs: Sequence[PreparedRun],
    sensors: Sequence[str],
    chosen: Sequence[int],
) -> None:
    """Widen the plausible readings and the largest offset according to the new runs."""
    for entry in table["sensors"]:
        if entry["name"] not in sensors:
            continue
        new = sensor_table(entry["name"], runs, sensors.index(entry["name"]))
        for names, better in ((("low", "trained_low"), min), (("high", "trained_high"), max)):
            for name in names:
                entry[name] = better(entry[name], new[name])
        for name in ("rate_per_s", "noise"):
            entry[name] = max(entry[name], new[name])
    rows = [run.complete(chosen) for run in runs]
    limits = limits_table(model.geometry, rows, model.limits.tool_length_mm, {})
    old = table["limits"]
    old["offset_um"] = max(old["offset_um"], limits["offset_um"])


def _together(
    old: Sequence[Sequence[float] | None], new: Sequence[Sequence[float] | None]
) -> list[Any]:
    if not old:
        return list(new)
    # Keep the shortest duration: after a run that ended early, other short runs would look whole.
    return [
        a or b
        if a is None or b is None
        else [a[0] if name == "duration" else min(a[0], b[0]), max(a[1], b[1])]
        for (name, _), a, b in zip(NAMES, old, new, strict=True)
    ]


def _listed_left(record: RunLeft) -> dict[str, Any]:
    axes = {axis: {"no_model": v.none, "model": v.left} for axis, v in record.axes.items()}
    return {"run": record.run, "axes": axes}
