"""The studies' own experiment, rebuilt: learn on the step spectrum, predict another one.

    python -m benchmarks.studies [--write]

Two machines: the jig borer's plant and a finite-element spindle (`benchmarks.studies_machines`).
Every figure is printed beside the study's, with a sentence on each difference; ``--write`` writes
the same page to docs/studies.md. About two minutes.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from tqdm import tqdm

from benchmarks.studies_machines import finite_element_spindle, jig_borer
from benchmarks.studies_text import PAGE
from fmu_compensator.fit.columns import MeasuredColumns
from fmu_compensator.fit.contestants import Contestant, contestants, held
from fmu_compensator.fit.data import Prepared, prepare
from fmu_compensator.fit.fitting import compensator_text, fit_compensator
from fmu_compensator.fit.training import TrainingRun
from fmu_compensator.runtime.compensator import Compensator
from fmu_compensator.runtime.modelfile import parse_model
from measurement.drift import measured_drift, tool_tip_drift
from measurement.files import write_atomically
from measurement.rig import POSE, FivePointRig, rig_from_table
from measurement.runs import Run
from plant_model.machine_file import read_machine

ROOT = Path(__file__).resolve().parents[1]
STEP, OTHER = "step_speed", "random_speed"
FOUR = ("training_down", "training_random", "training_stops", "training_warm_hall")
UNSEEN = ("step_speed", "random_speed", "stop_and_go")
MODELS = "bp,ga_bp,bp_5_5,mlr,arma,ne,fem,vac,vac_least_squares,vac_adaptive,arx,thermal_states"
TOOLS_MM = (100.0, 240.0)
NEAR_END = 1.01
"""A training has converged where its error is within this factor of its last one [1]."""

STUDY_FIT = {"bp": (97.8, 94.1, 96.6), "ga_bp": (97.3, 97.6, 97.7)}
STUDY_UNSEEN = {"bp": (90.0, 76.1, 60.5), "ga_bp": (92.5, 91.4, 91.4)}
STUDY_COMPENSATED = {
    "ga_bp": ((82, 85, 85), "39.6 to 11.1, 24.7 to 3.6"),
    "bp": ((62, 76, 67), ""),
    "arma_one_step": ((77, 88, 89), "39.6 to 7, 24.6 to 2.8"),
    "bp_5_5": ((64, 85, 70), ""),
    "mlr": ((75, 74, 63), ""),
}
"""Improvement of X, Y, Z [%]; axial maximum and mean before and after [um]."""


@dataclass(frozen=True)
class Judged:
    """One model on the run that it learnt from and on the one that it never saw.

    Attributes
    ----------
    name, title : str
    fit, unseen : pairs of array (n, m)
        Measured and predicted targets [um, urad].
    report : dict
        Diagnostics of the fit.
    """

    name: str
    title: str
    fit: tuple[np.ndarray, np.ndarray]
    unseen: tuple[np.ndarray, np.ndarray]
    report: dict[str, Any]


def judged(train: Run, unseen: Run, rig: Any, entrants: Sequence[Contestant]) -> list[Judged]:
    """Return how every model does; those that use measurements also one step ahead."""
    found = []
    for entrant in tqdm(entrants, desc=train.name, unit="model", disable=None, leave=False):
        form = entrant.recipe.input_form if entrant.recipe else "rise"
        learnt = prepare([train], rig, form)
        other = prepare([unseen], rig, form, sensors=learnt.sensors)
        if entrant.recipe is None:
            rows = [part.runs[0].history([]) for part in (learnt, other)]
            one_step = [held(run, run.targets) for run in rows]
            if entrant.name == "persistence":
                found.append(_pair("persistence_one_step", "Persistence", rows, one_step, {}))
            continue
        found += _model(entrant, learnt, other)
    return found


def _model(entrant: Contestant, learnt: Prepared, other: Prepared) -> list[Judged]:
    recipe = entrant.recipe
    assert recipe is not None
    chosen, _ = recipe.choose(learnt, learnt.runs)
    fitted = recipe.fit(learnt, learnt.runs, chosen)
    rows = [recipe.rows(part.runs[0], chosen) for part in (learnt, other)]
    report = fitted.report()
    free = _pair(entrant.name, entrant.title, rows, [fitted.predict(run) for run in rows], report)
    if entrant.name != "arma":
        return [free]
    told = [fitted.predict(run, run.targets) for run in rows]
    return [free, _pair("arma_one_step", entrant.title, rows, told, report)]


def _pair(
    name: str, title: str, rows: Sequence[TrainingRun], values: Sequence[np.ndarray], report: Any
) -> Judged:
    first, second = (
        (run.targets[run.known], value[run.known]) for run, value in zip(rows, values, strict=True)
    )
    return Judged(name, title, first, second, report)


def etas(pair: tuple[np.ndarray, np.ndarray]) -> np.ndarray:
    """Return the predictive ability of each target, 1 - sum|e| / sum|y| [%]."""
    measured, predicted = pair
    return 100.0 * (1.0 - np.abs(measured - predicted).sum(axis=0) / np.abs(measured).sum(axis=0))


def prediction_table(found: Iterable[Judged]) -> str:
    """Return fit and unseen predictive ability of elongation, yaw and pitch, ours (study's)."""
    rows = []
    for one in found:
        cells = [_title(one)]
        for study, pair in ((STUDY_FIT, one.fit), (STUDY_UNSEEN, one.unseen)):
            theirs = study.get(one.name, ())
            for k, ours in enumerate(etas(pair)[:3]):
                cells.append(f"{ours:.1f}" + (f" ({theirs[k]:.1f})" if k < len(theirs) else ""))
        rows.append(cells)
    targets = ("E", "yaw", "pitch")[: (len(rows[0]) - 1) // 2]
    head = [f"{what} {target}" for what in ("fit", "unseen") for target in targets]
    return _table(["eta [%], ours (study's)", *head], rows)


def convergence_table(machines: dict[str, list[Judged]]) -> str:
    """Return how the trainings of BP and GA-BP went."""
    rows = []
    for machine, found in machines.items():
        for one in found:
            if one.name not in ("bp", "ga_bp"):
                continue
            curve = np.array(one.report["curve"])
            near = int(np.argmax(curve <= NEAR_END * curve[-1]))
            nodes = "-".join(map(str, one.report["nodes"]))
            total = one.report["iterations"]
            cells = [f"{value:.2g}" for value in (curve[0], curve[min(10, len(curve) - 1)])]
            rows.append(
                [machine, one.title, nodes, *cells, f"{curve[-1]:.2g}", str(near), str(total)]
            )
    head = ["machine", "model", "nodes", "error at the start", "after 10 iterations", "at the end"]
    return _table([*head, "iterations to within 1 % of it", "iterations"], rows)


def compensation_table(found: Iterable[Judged], rig: FivePointRig) -> str:
    """Return what is left of the tool tip's drift on the unseen run, by tool length."""
    rows = []
    for one in found:
        theirs, axial = STUDY_COMPENSATED.get(one.name, ((), ""))
        cells = [_title(one), " / ".join(map(str, theirs)), axial]
        for tool in TOOLS_MM:
            before, predicted = (
                tool_tip_drift(pd.DataFrame(targets, columns=list(POSE)), rig, tool).to_numpy()
                for targets in one.unseen
            )
            left, before = np.abs(before - predicted), np.abs(before)
            better = 100.0 * (1.0 - left.mean(axis=0) / before.mean(axis=0))
            cells.append(" / ".join(f"{value:.0f}" for value in better))
        cells.append(
            f"{before[:, 2].max():.1f} to {left[:, 2].max():.1f}, "
            f"{before[:, 2].mean():.1f} to {left[:, 2].mean():.1f}"
        )
        rows.append(cells)
    ours = [f"ours, tool {tool:g} mm" for tool in TOOLS_MM]
    axial = "axial max, mean [um]"
    return _table(
        ["X / Y / Z better by [%]", "study", f"study, {axial}", *ours, f"ours, {axial}"], rows
    )


def interval_table(train: Sequence[Run], unseen: Sequence[Run], rig: FivePointRig) -> str:
    """Return how well compensators from four runs do, and how often their interval holds."""
    rows = []
    for model in ("mlr", "arx", "thermal_states"):
        table = fit_compensator(train, rig, model, limits={"slew_um_per_s": 1e4})
        found = parse_model(compensator_text(table), model)
        for tool in TOOLS_MM:
            left, widths = _run(found, unseen, rig, tool)
            inside = 100.0 * (np.abs(left) <= widths).mean(axis=0)
            rms, width = np.sqrt((left**2).mean(axis=0)), widths.mean(axis=0)
            cells = [f"{a:.2f}" for a in rms] + [f"{w:.2f}" for w in width]
            rows.append([f"`{model}`", f"{tool:g}", *cells, *(f"{share:.0f}" for share in inside)])
    head = [f"{what} {axis}" for what in ("RMSE", "half width", "within [%]") for axis in "XYZ"]
    return _table(["model", "tool [mm]", *head], rows)


def _run(
    model: Any, unseen: Sequence[Run], rig: FivePointRig, tool: float
) -> tuple[np.ndarray, np.ndarray]:
    """Return what the compensator leaves of the unseen runs' drift, and its half widths [um]."""
    left, widths = [], []
    for run in unseen:
        compensator = Compensator(model)
        columns = [f"{sensor.name}_degC" for sensor in model.sensors]
        readings, speed = run.frame[columns].to_numpy(), run.frame["speed_rpm"].to_numpy()
        drift = measured_drift(run, rig, tool, "rise").to_numpy()
        step = float(np.median(np.diff(run.time_s)))
        for k, time in enumerate(run.time_s):
            out = compensator.step(time, step, readings[k].tolist(), float(speed[k]), tool)
            left.append(drift[k] + out[:3])
            widths.append(out[6:9])
    return np.array(left), np.array(widths)


def _title(one: Judged) -> str:
    if one.name == "arma":
        return f"{one.title}, free-running"
    return f"{one.title}, one step ahead" if one.name.endswith("_one_step") else one.title


def _table(head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """Return a Markdown table."""
    lines = [head, ["---"] * len(head), *rows]
    return "\n".join(f"| {' | '.join(row)} |" for row in lines)


def main() -> int:
    """Run everything and print the page."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--write", action="store_true", help="also write docs/studies.md")
    args = parser.parse_args()
    rig = rig_from_table(dict(read_machine("jig_borer").rig), "jig_borer")
    assert isinstance(rig, FivePointRig)
    entrants = contestants(MODELS.split(","))
    lumps = judged(*jig_borer([STEP, OTHER]), rig, entrants)
    elements = judged(
        *finite_element_spindle([STEP, OTHER]), MeasuredColumns(["elongation_um"]), entrants
    )
    page = PAGE.format(
        lumps=prediction_table(lumps),
        elements=prediction_table(elements),
        convergence=convergence_table({"jig borer": lumps, "finite elements": elements}),
        compensation=compensation_table(lumps, rig),
        intervals=interval_table(jig_borer(FOUR), jig_borer(UNSEEN), rig),
    )
    print(page)
    if args.write:
        write_atomically(ROOT / "docs" / "studies.md", page)
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
