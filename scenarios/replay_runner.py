"""Replays measured runs through a compensator and writes the results folder."""

from __future__ import annotations

import re
import tempfile
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from tqdm import tqdm

from fmu_compensator.driving import late_lines
from fmu_compensator.fit.advice import advice
from fmu_compensator.fit.promise import FEWEST_JUDGED_ROWS
from fmu_compensator.leaps import leap_lines_of
from fmu_compensator.monitoring.sensors import Agreement, swap_lines
from fmu_compensator.runtime.modelfile import Model
from fmu_compensator.signs import opposite_columns, sign_lines
from fmu_packaging.reference import DECIMALS
from measurement.doubts import doubt_lines
from measurement.errors import BadInput, counted
from measurement.faults import (
    GROSS,
    LEVELS,
    by_column,
    cleaned,
    find_faults,
    group_line,
    looked_over,
)
from measurement.resampling import SLOW_S
from measurement.rig import AXES
from measurement.runs import read_run, write_run
from measurement.units import split_column
from measurement.warm import named_warm
from plant_model.machine_file import read_machine
from scenarios.fit_text import errors_text
from scenarios.fmu_files import check_fmus, find_fmu
from scenarios.pages.charts import SHOWN
from scenarios.probing import Probing
from scenarios.recording import without_offsets
from scenarios.replay import (
    LABEL_HELD,
    LABEL_PROBED,
    Replay,
    chart_of,
    model_of,
    replay,
    results_of,
    rig_of_model,
)
from scenarios.results import check_folder, results_folder, write_report
from scenarios.runner import fmu_facts, versions
from scenarios.table import Group, group_of, overall

ALL = "All runs together"
_WITH_PROBES = " with probes"
NOTE = (
    "Largest and mean absolute drift, as the run's own displacement sensors show it, and what is "
    "left of it with the offsets that the compensator sent. Better by: 1 - mean with / mean "
    "without compensation."
)


def run_replay(
    compensator: str,
    runs: Sequence[Path],
    out: Path,
    fmu_dir: Path,
    *,
    near: Path,
    tool_length_mm: float | None = None,
    machine: str | None = None,
    keep_frozen: bool = False,
    probing: Probing | None = None,
    title: str = "Replay of measured runs",
    description: str = "",
    quiet: bool = False,
) -> tuple[dict[str, Any], list[Group], list[str]]:
    """Replay runs and write the results folder.

    Parameters
    ----------
    compensator : str
        An FMU, or a compensator file (.json).
    runs : sequence of Path
        At least one run file.
    out, fmu_dir, near : Path
        Results folder; FMU folder; folder to which the compensator's path may be relative.
    tool_length_mm : float, optional
        Tool length at which a five-point rig's drift is evaluated [mm] (default: 100 mm, or the
        nearest allowed length).
    machine : str, optional
        Machine whose five-point rig names the displacement sensors (default: as in training).
    keep_frozen : bool
        Count rows in which a displacement sensor was frozen or at the end of its range.
    probing : Probing, optional
        When the compensator is given a probe of the run's own drift.
    title, description : str
        Texts of the report.
    quiet : bool
        No progress bar.

    Returns
    -------
    table : dict
        The content of ``table.json``.
    groups : list of Group
        The headline table; with several runs, all together come first.
    notes : list of str
        What a reader must know, one line each.

    Raises
    ------
    BadInput, ModelFileError
        If the compensator or a run cannot be used; no folder is left behind.
    FmuError
        If the FMU fails; no folder is left behind.
    """
    check_folder(out)
    recorded = looked_over([read_run(path) for path in runs])
    names = _file_names([run.name for run in recorded])
    check_fmus((), [compensator], fmu_dir, near)
    with tempfile.TemporaryDirectory(prefix="spindle-drift-built-") as work:
        fmu = find_fmu(compensator, fmu_dir, near, Path(work), quiet=quiet, native=True)
        model = model_of(fmu)
        rig = rig_of_model(model, None if machine is None else read_machine(machine))
        length = model.limits.judged_tool(tool_length_mm)
        replays = [
            replay(fmu, model, run, rig, length, keep_frozen=keep_frozen, probing=probing)
            for run in tqdm(recorded, desc="replay", disable=quiet or None, leave=False)
        ]
    groups = [group_of(entry.run.name, results_of(entry)) for entry in replays]
    notes = [*_left(replays, model), *_worse(groups), *_notes(replays)]
    notes += late_lines(model, recorded, rig)
    if len(groups) > 1:
        groups.insert(0, overall(groups, ALL))
    left = cleaned(recorded, find_faults(recorded), GROSS)
    agreement = Agreement(model)
    notes += swap_lines((run.name, agreement.swapped(run)) for run in left)
    notes += advice(model, recorded, left, rig, length, probes=probing is None)
    with results_folder(out) as folder:
        for entry, name in zip(replays, names, strict=True):
            write_run(entry.frame.round(DECIMALS), folder / f"results_{name}.csv")
        charts = [
            chart_of(entry, f"drift_{name}") for entry, name in zip(replays, names, strict=True)
        ]
        facts = {
            "compensator": {"name": model.name, "title": model.title},
            "fmus": [asdict(replays[0].fmu)],
            "runs": list(map(_run_facts, replays, names)),
            "notes": notes,
            "versions": versions(),
        }
        table = write_report(
            folder,
            groups,
            facts,
            charts,
            title=title,
            kicker="spindle-drift replay",
            description=description or f"{model.title}, driven by measured runs.",
            table_note=NOTE,
            notes=notes,
            timelines=[
                (entry.run.name, entry.events, float(np.ptp(entry.run.time_s))) for entry in replays
            ],
            facts=[
                ("Compensator", f"{model.title} ({model.name}), fitted on {_fitted(model)}"),
                *fmu_facts([replays[0].fmu]),
                *(("Run", f"{run.name}: SHA-256 {run.sha256}") for run in recorded),
            ],
        )
    return table, groups, notes


def _fitted(model: Any) -> str:
    runs = [str(run["name"]) for run in model.provenance.get("runs", [])]
    return ", ".join(runs) if runs else "runs that the file does not name"


def _left(replays: Sequence[Replay], model: Model) -> list[str]:
    """Return what remained, each run counted as one, beside what the compensator file promises."""
    by_label: dict[str, list[pd.DataFrame]] = {}
    for entry in replays:
        for _, label, frame in results_of(entry):
            by_label.setdefault(label, []).append(frame)
    said = []
    for label, frames in by_label.items():
        if label != LABEL_HELD and (errors := _errors(frames)):
            said.append(f"{errors_text(errors)}{_WITH_PROBES if label == LABEL_PROBED else ''}")
    promised = (model.provenance["figures"].get("unseen") or {}).get("promised")
    if said and promised:
        said.append(f"promised by the compensator file: {errors_text(promised)}")
    return [f"RMSE [um] without -> with compensation: {'; '.join(said)}."] if said else []


def _errors(frames: Sequence[pd.DataFrame]) -> dict[str, dict[str, float]]:
    errors: dict[str, dict[str, float]] = {}
    for axis in AXES:
        names = [f"drift_{axis}_um", f"error_{axis}_um"]
        both = [frame[names].dropna() for frame in frames if set(names) <= set(frame)]
        squares = [(rows**2).mean() for rows in both if len(rows) >= FEWEST_JUDGED_ROWS]
        if squares:
            none, left = np.sqrt(np.mean(squares, axis=0)).tolist()
            errors[axis] = {"no_model": none, "model": left}
    return errors


def _worse(groups: Sequence[Group]) -> list[str]:
    """Return a line on the runs and axes whose mean is larger than without compensation."""
    found = [
        f"{group.title} ({axis}{_WITH_PROBES if row.label == LABEL_PROBED else ''})"
        for group in groups
        for row in group.rows
        if row.label != LABEL_HELD
        for axis, figures in row.axes.items()
        if figures.after_mean_um > figures.before_mean_um
    ]
    return [f"Worse than without compensation: {', '.join(found)}."] if found else []


def _notes(replays: Sequence[Replay]) -> list[str]:
    notes = doubt_lines([entry.run for entry in replays])
    left_out = sum(entry.left_out for entry in replays)
    if left_out:
        rows = sum(len(entry.frame) for entry in replays)
        notes.append(
            f"{left_out} of {rows} rows are not counted: a displacement sensor was broken."
        )
    if warm := named_warm([entry.run for entry in replays]):
        notes.append(
            f"Started while the machine was warm: {warm}. The compensator assumes a cold start, so "
            "the drift that was already there shows as its error."
        )
    for entry in replays:
        errors = entry.frame.filter(regex="^error_._um$")
        silent = [str(name)[len("error_")] for name in errors.columns[errors.isna().all()]]
        if silent:
            axes = ", ".join(silent)
            notes.append(f"{entry.run.name}: no row has a sound displacement to judge {axes} by.")
    unprobed = [entry for entry in replays if entry.probes is None]
    notes += sign_lines((entry.run.name, opposite_columns(entry.frame)) for entry in unprobed)
    notes += [line for entry in unprobed for line in leap_lines_of(entry.run, entry.frame)]
    for entry in replays:
        notes += without_offsets(entry.run.name, entry.frame, entry.events)
    notes += [_probes(entry) for entry in replays if entry.probes is not None]
    faults = [fault for entry in replays for fault in entry.faults]
    gross = [group for group in by_column(faults) if group[0].is_gross or group[0].kind in LEVELS]
    notes += [group_line(group) for group in gross]
    if any(split_column(group[0].column)[1] == "degC" for group in gross):
        notes.append("The compensator was given all thermometer readings unchanged.")
    return notes


def _probes(entry: Replay) -> str:
    """Return how often a run was probed, and when."""
    time_s = entry.run.time_s
    taken = time_s[list(entry.probes or ())]
    if not len(taken):
        return f"{entry.run.name}: no probe."
    hours = max(float(time_s[-1] - time_s[0]) / 3600.0, 1e-9)
    minutes = [f"{(value - time_s[0]) / 60.0:.0f}" for value in taken]
    shown = ", ".join(minutes[:SHOWN]) + (", ..." if len(minutes) > SHOWN else "")
    text = (
        f"{entry.run.name}: {counted(len(taken), 'probe')}, "
        f"{len(taken) / hours:.1f} an hour, at {shown} min"
    )
    step_s = float(np.median(np.diff(time_s))) if len(time_s) > 1 else 0.0
    hasty = int(np.sum(np.diff(taken) < SLOW_S + 2.0 * step_s))
    if hasty > len(taken) / 2:
        text += (
            f"; most follow each other as soon as {SLOW_S / 60:g} min allow: "
            "a probe does not keep the uncertainty below the limit any longer"
        )
    return f"{text}."


def _run_facts(entry: Replay, name: str) -> dict[str, Any]:
    return {
        "name": entry.run.name,
        "sha256": entry.run.sha256,
        "rows": len(entry.frame),
        "left_out": entry.left_out,
        "probed_s": None
        if entry.probes is None
        else [float(entry.run.time_s[row]) for row in entry.probes],
        "faults": [fault.to_dict() for fault in entry.faults],
        "file": f"results_{name}.csv",
        "events": [asdict(event) for event in entry.events],
    }


def _file_names(names: Sequence[str]) -> list[str]:
    """Return names for files and for elements of a page, one per run.

    Raises
    ------
    BadInput
        If two runs have the same name, so that their results could not be distinguished.
    """
    twice = next((name for name in names if list(names).count(name) > 1), None)
    if twice is not None:
        raise BadInput(twice, "", "is the name of two of the runs; rename one")
    plain = [re.sub(r"[^A-Za-z0-9_-]+", "_", name) or "run" for name in names]
    return [
        name if plain.count(name) == 1 else f"{name}_{number}"
        for number, name in enumerate(plain, 1)
    ]
