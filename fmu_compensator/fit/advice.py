"""Advice after a compensator was tried on runs: which run to measure, or to probe."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from fmu_compensator.driving import begins_late, drive, learnt_as
from fmu_compensator.fit.data import prepare
from fmu_compensator.fit.features import Sample
from fmu_compensator.fit.gaussian import Gaussian
from fmu_compensator.fit.promise import FEWEST_JUDGED_ROWS, by_axis, left_of
from fmu_compensator.fit.run_conditions import conditions_of, values_of
from fmu_compensator.fit.updating import gaussian_of, sample_of_run
from fmu_compensator.runtime.compensator import UNTRAINED
from fmu_compensator.runtime.modelfile import Model
from measurement.rig import Rig
from measurement.runs import Run


def advice(
    model: Model,
    runs: Sequence[Run],
    left: Sequence[Run],
    rig: Rig,
    tool_length_mm: float,
    *,
    probes: bool = True,
) -> list[str]:
    """Return up to three lines: source of the error, what to measure, effect of a probe.

    Parameters
    ----------
    model : Model
        The compensator that was tried.
    runs : sequence of Run
        Runs that it was tried on.
    left : sequence of Run
        The same runs without broken readings.
    rig : Rig
        Meaning of the displacements.
    tool_length_mm : float
        Tool length at which the drift is taken.
    probes : bool
        Whether to tell the effect of a probe: not where one was tried.
    """
    pairs = list(zip(runs, left, strict=True))
    driven = [drive(model, run, clean, rig, tool_length_mm) for run, clean in pairs]
    if not any(np.isfinite(record.error).any() for record in driven):
        return []
    squares = [np.nansum(record.error**2, axis=1) for record in driven]
    total = sum(float(squared.sum()) for squared in squares)
    outside = sum(
        float(squared[each.status == UNTRAINED].sum())
        for squared, each in zip(squares, driven, strict=True)
    )
    share = outside / total if total > 0.0 else 0.0
    lines = [f"{share:.0%} of the squared error came from conditions outside training (status 2)."]
    named = _most_telling(model, runs, rig)
    if named is not None:
        lines.append(named)
    if not probes:
        return lines
    soon = [at for at, (_, clean) in enumerate(pairs) if not begins_late(model, clean, rig)]
    probed = [drive(model, *pairs[at], rig, tool_length_mm, probe_every_s=3600.0) for at in soon]
    before = by_axis([left_of(driven[at], "") for at in soon])
    if not before:  # all begin too late, or end too early
        return lines
    after = by_axis([left_of(record, "") for record in probed])
    cells = [f"{axis} {after[axis]['model']:.1f} um" for axis in before if axis in after]
    beside = [f"{axis} {row['model']:.1f} um" for axis, row in before.items()]
    lines.append(
        f"With an exact probe every hour the RMSE would be {', '.join(cells)} "
        f"(without: {', '.join(beside)})."
    )
    return lines


def _most_telling(model: Model, runs: Sequence[Run], rig: Rig) -> str | None:
    """Return the new run that would reduce the uncertainty of the others most if learnt from."""
    if len(runs) < 2:
        return None
    names = [sensor.name for sensor in model.sensors]
    prepared = prepare(runs, rig, model.input_form, sensors=names)
    used = [model.sensors[index].name for index in model.chosen]
    if any(name not in prepared.sensors for name in used):
        return None
    chosen = [prepared.sensors.index(name) for name in used]
    # The runs that `update` would not refuse.
    pairs = [
        (run, sample_of_run(model, rows, chosen))
        for run, rows in zip(runs, prepared.runs, strict=True)
        if rows.complete(chosen).known.sum() >= FEWEST_JUDGED_ROWS
    ]
    gaussian = gaussian_of(model.table["gaussian"])
    best, gain, now = runs[0], 0.0, 0.0
    for run, sample in pairs:
        if learnt_as(model, run) is not None:
            continue
        others = [other for _, other in pairs if other is not sample]
        before = _uncertainty(others, gaussian)
        gained = before - _uncertainty(others, gaussian.updated([sample]))
        if gained > gain:
            best, gain, now = run, gained, before
    if not gain:
        return None
    ranges = model.provenance["figures"].get("conditions") or ()
    new = [condition.text for condition in conditions_of(best, used, ranges) if condition.is_new]
    start = values_of(best, used)[0]
    what = "; ".join(new) or f"temperature at the start {start:.1f} degC"
    return (
        f"Best run to learn from next: {best.name} ({what}). An `update` with it reduces "
        f"the weights' share of the uncertainty in the others by {gain / now:.0%}."
    )


def _uncertainty(samples: Sequence[Sample], model: Gaussian) -> float:
    """Return the mean standard deviation due to the weights, over that of the noise [1]."""
    parts = [np.sqrt(model.novelty(sample.features)).mean() for sample in samples]
    return float(np.mean(parts)) if parts else 0.0
