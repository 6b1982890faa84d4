"""Compensators learnt from four runs of the jig borer: what they leave, and how often they hold."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import repeat

import numpy as np

from benchmarks.results_page import as_table
from benchmarks.studies.machines import truth
from benchmarks.trust.questions import TRAINING, simulated
from fmu_compensator.driving import answers, inputs_of
from fmu_compensator.fit.fitting import compensator_text, fit_compensator
from fmu_compensator.runtime.modelfile import Model, parse_model
from measurement.drift import measured_drift
from measurement.rig import FivePointRig
from measurement.runs import Run

UNSEEN = ("step_speed", "random_speed", "stop_and_go")
MODELS = ("mlr", "arx", "thermal_states")
TOOLS_MM = (100.0, 240.0)


def interval_rows(model: str) -> list[list[str]]:
    """Return how well a compensator from four runs does, and how often its interval holds."""
    rig = truth("jig_borer").rig
    assert isinstance(rig, FivePointRig)
    unseen = [simulated(name) for name in UNSEEN]
    learnt = [simulated(name) for name in TRAINING]
    table = fit_compensator(learnt, rig, model, limits={"slew_um_per_s": 1e4})
    found = parse_model(compensator_text(table), model)
    rows = []
    for tool in TOOLS_MM:
        left, widths = _run(found, unseen, rig, tool)
        inside = 100.0 * (np.abs(left) <= widths).mean(axis=0)
        rms, width = np.sqrt((left**2).mean(axis=0)), widths.mean(axis=0)
        cells = [f"{a:.2f}" for a in rms] + [f"{w:.2f}" for w in width]
        rows.append([f"`{model}`", f"{tool:g}", *cells, *(f"{share:.0f}" for share in inside)])
    return rows


def interval_table(rows: Sequence[Sequence[str]]) -> str:
    """Return the rows of all models as a table."""
    head = [f"{what} {axis}" for what in ("RMSE", "half width", "within [%]") for axis in "XYZ"]
    return as_table(["model", "tool [mm]", *head], rows)


def _run(
    model: Model, unseen: Sequence[Run], rig: FivePointRig, tool: float
) -> tuple[np.ndarray, np.ndarray]:
    """Return what the compensator leaves of the unseen runs' drift, and its half widths [um]."""
    left, widths = [], []
    for run in unseen:
        outputs = sent(model, run, tool)
        left.append(measured_drift(run, rig, tool, "rise").to_numpy() + outputs[:, :3])
        widths.append(outputs[:, 6:9])
    return np.concatenate(left), np.concatenate(widths)


def sent(model: Model, run: Run, tool: float) -> np.ndarray:
    """Return a row of numbers that a compensator sends for every row of a run."""
    readings, speed = inputs_of(model, run)
    inputs = zip(run.time_s, readings, speed, repeat(None))
    return np.array([output[:9] for output in answers(model, inputs, tool)])
