"""New runs into a compensator that kept its old ones."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from inspect import signature
from typing import Any

from fmu_compensator.fit.fitting import fit_compensator
from fmu_compensator.fit.points import choose_points
from fmu_compensator.fit.remembered import remembered_runs
from fmu_compensator.runtime.modelfile import Model
from measurement.errors import BadInput
from measurement.rig import Rig
from measurement.runs import Run

GREY = frozenset(signature(choose_points).parameters)
KEPT = ("slew_um_per_s", "hold_s", "recover_s")


def update_compensator(
    model: Model,
    runs: Sequence[Run],
    *,
    choose: bool = False,
    candidates: Sequence[str] | None = None,
    created: str | None = None,
    jobs: int = 1,
    on_step: Callable[[str, float], None] = lambda label, done: None,
) -> dict[str, Any]:
    """Fit a compensator anew to the runs that it kept and to new ones.

    Everything is learnt again, as `fit_compensator` does from all the runs: the points, the
    numbers, how far to believe them, and what is promised. Name, geometry, limits, tool lengths and
    options stay.

    Parameters
    ----------
    model : Model
        A compensator file that keeps its training runs.
    runs : sequence of Run
        New runs, with the same thermometers and displacements.
    choose : bool
        Choose the error model anew. By default its kind and options stay.
    candidates : sequence of str, optional
        Kinds to choose among.
    created : str, optional
        Date for the file (YYYY-MM-DD).
    jobs : int
        Processes.
    on_step : callable
        Told a model after each of its fits, and which share of the work is done [1].

    Returns
    -------
    dict
        The new file's content, checked.

    Raises
    ------
    BadInput
        If the file keeps no runs, a new run is an old one, or the fit fails.
    """
    table = model.table
    old, rig = remembered_runs(table, model.source)
    _check_new(old, runs, rig, model)
    provenance = table["provenance"]
    options = dict(provenance["options"])
    points, form = options.pop("points", None), options.pop("input_form", None)
    grey = {name: options.pop(name) for name in list(options) if name in GREY}
    kind = None if choose else str(table["error_model"]["kind"])
    limits = table["limits"]
    new = fit_compensator(
        [*old, *runs],
        rig,
        kind,
        points=None if choose else points,
        input_form=None if choose else form,
        grey=grey,
        sensors=[sensor.name for sensor in model.sensors],
        geometry_form=table["geometry"].get("form", "rigid"),
        tool_length_mm=tuple(limits["tool_length_mm"]),
        limits={name: limits[name] for name in KEPT},
        leave_out_frozen=bool(table["training"].get("leave_out_frozen", True)),
        name=model.name,
        created=created,
        candidates=candidates,
        jobs=jobs,
        on_step=on_step,
        **({} if choose else options),
    )
    new["provenance"]["runs"][: len(old)] = provenance["runs"]
    # Larger drift may have come with the new runs; a limit that somebody set is not lowered.
    new["limits"]["offset_um"] = max(limits["offset_um"], new["limits"]["offset_um"])
    return new


def _check_new(old: Sequence[Run], runs: Sequence[Run], rig: Rig, model: Model) -> None:
    known = {run.sha256: run.name for run in old}
    for run in runs:
        if run.sha256 in known:
            problem = f"is already in the compensator, as {known[run.sha256]}"
            raise BadInput(run.path or run.name, "", problem)
        used = [f"{model.sensors[index].name}_degC" for index in model.chosen]
        lost = next((name for name in [*used, *rig.columns] if name not in run.frame), None)
        if lost is not None:
            problem = "is missing, and the compensator was fitted with it"
            raise BadInput(run.path or run.name, f"column {lost}", problem)
