"""The training runs as a compensator file keeps them, so that `update` needs no old files.

What is kept is what a fit looks at: temperatures, speed and the rig's displacements, broken
readings left out, averaged onto an even grid of at most `MOST_ROWS` rows a run. A fit tells no more
from the rest: errors of a run are alike for many minutes.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import pandas as pd

from fmu_compensator.fit.data import left_out
from measurement.errors import BadInput, shown
from measurement.faults import cleaned, find_faults
from measurement.rig import Rig, rig_from_table
from measurement.runs import Run
from measurement.units import column

MOST_ROWS, FEWEST_ROWS = 120, 40
MOST_TOGETHER = 12_000
"""Rows of all runs, as far as each has its fewest."""
MOST_RUNS = 200
DECIMALS = {"degC": 2, "um": 2, "rpm": 1}
SPEED = "speed_rpm"


def remembered(
    runs: Sequence[Run], rig: Rig, sensors: Sequence[str], leave_out_frozen: bool = True
) -> dict[str, Any]:
    """Return the table for the compensator file.

    Parameters
    ----------
    runs : sequence of Run
        The training runs; those that a file remembered stay as they were if short enough.
    rig : rig of `measurement.rig`
        What the displacements mean.
    sensors : sequence of str
        Signal names of the temperatures.
    leave_out_frozen : bool
        Whether frozen displacements were left out of the fit.

    Returns
    -------
    dict
        ``rig``, ``leave_out_frozen`` and ``runs``: each with name, sha256 and columns, which are
        texts with a number a row, ``-`` where there is none.
    """
    if len(runs) > MOST_RUNS:
        raise BadInput("fit", "runs", f"{len(runs)} are too many to keep: {MOST_RUNS} at most")
    rows = min(max(MOST_TOGETHER // max(len(runs), 1), FEWEST_ROWS), MOST_ROWS)
    wanted = [column(name, "degC") for name in sensors]
    found = []
    usable = cleaned(runs, find_faults(runs), left_out(leave_out_frozen))
    for run, left in zip(runs, usable, strict=True):
        kept = thinned(left, rows)
        names = [name for name in (SPEED, *wanted, *rig.columns) if name in kept.frame]
        columns = {"time_s": _text(kept.time_s, 1)} | {
            name: _text(kept.frame[name].to_numpy(float), DECIMALS[name.rsplit("_", 1)[1]])
            for name in names
        }
        found.append({"name": run.name, "sha256": run.sha256, "columns": columns})
    return {
        "rig": rig.model_dump(mode="json"),
        "leave_out_frozen": leave_out_frozen,
        "runs": found,
    }


def thinned(run: Run, rows: int) -> Run:
    """Return a run with about so many rows at most, from its first time on."""
    time_s = run.time_s
    if len(time_s) <= rows * 1.1:
        return run
    usual = float(np.median(np.diff(time_s)))
    step = max(float(time_s[-1] - time_s[0]) / rows, usual)
    thin = run.resampled(step, start_s=float(time_s[0]))
    there = np.isfinite(thin.frame.drop(columns="time_s").to_numpy(float)).any(axis=1)
    return Run(run.name, thin.frame[there], run.path, run.sha256)


def remembered_runs(table: Mapping[str, Any], source: str) -> tuple[list[Run], Rig]:
    """Return the training runs of a compensator file, and their rig.

    Parameters
    ----------
    table : mapping
        The file's content.
    source : str
        Named in refusals.

    Returns
    -------
    runs : list of Run
    rig : rig
        What their displacement columns mean.

    Raises
    ------
    BadInput
        If the file keeps none, or they cannot be read.
    """
    kept = table.get("training")
    if not isinstance(kept, Mapping):
        problem = "is missing, so the old runs are needed: fit it anew with all of them"
        raise BadInput(source, "training", problem)
    if not isinstance(kept.get("rig"), dict):
        raise BadInput(source, "training.rig", "must be a table")
    rig = rig_from_table(kept["rig"], f"{source}: training.rig")
    entries = kept.get("runs")
    if not isinstance(entries, list) or not entries:
        raise BadInput(source, "training.runs", "must be a list of runs")
    return [_run(entry, f"{source}: training.runs.{at}") for at, entry in enumerate(entries)], rig


def _run(entry: object, place: str) -> Run:
    if not isinstance(entry, Mapping) or not isinstance(entry.get("columns"), Mapping):
        raise BadInput(place, "", "must have a name, a sha256 and columns")
    columns = {
        str(name): _numbers(text, f"{place}.columns.{name}")
        for name, text in entry["columns"].items()
    }
    lengths = {name: len(values) for name, values in columns.items()}
    odd = next((name for name in lengths if lengths[name] != lengths.get("time_s")), None)
    if odd is not None:
        problem = f"has {lengths[odd]} rows, time_s {lengths.get('time_s', 0)}"
        raise BadInput(place, f"columns.{odd}", problem)
    return Run(str(entry.get("name")), pd.DataFrame(columns), None, str(entry.get("sha256")))


def _text(values: np.ndarray, decimals: int) -> str:
    return " ".join(
        f"{value:.{decimals}f}".rstrip("0").rstrip(".") if math.isfinite(value) else "-"
        for value in values.tolist()
    )


def _numbers(text: object, place: str) -> list[float]:
    values = []
    for row, word in enumerate(str(text).split(), 1):
        try:
            values.append(math.nan if word == "-" else float(word))
        except ValueError:
            raise BadInput(place, f"row {row}", f"{shown(word)} is not a number") from None
    return values
