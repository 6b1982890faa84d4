"""One compensator on one question: fitted, installed, and driven through runs it never saw."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from benchmarks.trust.questions import Question
from fmu_compensator.fit.data import prepare
from fmu_compensator.fit.fitting import compensator_text, fit_compensator
from fmu_compensator.runtime.compensator import OK, UNTRAINED, RunningCompensator
from fmu_compensator.runtime.modelfile import Model, parse_model
from measurement.drift import measured_drift
from measurement.errors import BadInput

CHOICE = "fit's own choice"
STEP_S = 60.0
"""Rows closer together are left out: a compensator's step is not what is judged here [s]."""
HALF_WIDTHS = 3.0
"""A sample further off than so many half widths is badly wrong [1]."""
TOOL_MM = 100.0


@dataclass(frozen=True)
class Result:
    """What came out.

    Attributes
    ----------
    data, question, model, kind : str
        Of the question; the model asked for, and what it was.
    unlike : bool
        Of the question.
    axes : dict
        By axis: RMSE without and with the compensator, pooled over the runs, each counting as one,
        and the medians over the runs [um]; share of samples in the interval [1]; mean half width
        [um].
    worst : float
        Largest ratio of a run's RMSE to that without a compensator, over runs and axes [1].
    outside : float
        Share of samples with status 2 [1].
    badly_wrong : float
        Share of samples with status 0 that are off by more than three half widths [1].
    """

    data: str
    question: str
    model: str
    kind: str
    unlike: bool
    axes: dict[str, dict[str, float]]
    worst: float
    outside: float
    badly_wrong: float

    @property
    def ratio(self) -> float:
        """Error over that of no compensation, geometric mean over the axes [1]."""
        logs = [np.log(axis["rmse"] / axis["none"]) for axis in self.axes.values()]
        return float(np.exp(np.mean(logs)))

    def to_dict(self) -> dict[str, Any]:
        """Return everything as JSON can carry it."""
        return asdict(self)


def judge(question: Question, model: str) -> Result:
    """Return how a model does on a question.

    Raises
    ------
    BadInput
        If it cannot be fitted.
    """
    named = None if model == CHOICE else model
    # The tool is fixed here; the slew limit of a control has no part in the model's error.
    table = fit_compensator(question.train, question.rig, named, limits={"slew_um_per_s": 1000.0})
    parsed = parse_model(compensator_text(table), model)
    runs = [run for run in (_driven(parsed, question, place) for place in _places(question)) if run]
    if not runs:
        raise BadInput(question.name, model, "the compensator started in no run")
    axes = {}
    names = runs[0]["axes"]
    for number, axis in enumerate(names):
        none = [np.sqrt(np.mean(run["drift"][:, number] ** 2)) for run in runs]
        left = [np.sqrt(np.mean(run["error"][:, number] ** 2)) for run in runs]
        width = [run["half_width"][:, number] for run in runs]
        inside = [
            np.abs(run["error"][:, number]) <= half for run, half in zip(runs, width, strict=True)
        ]
        axes[axis] = {
            "none": float(np.sqrt(np.mean(np.square(none)))),
            "rmse": float(np.sqrt(np.mean(np.square(left)))),
            "median_none": float(np.median(none)),
            "median": float(np.median(left)),
            "worst": float(max(a / b for a, b in zip(left, none, strict=True) if b > 0)),
            "coverage": float(np.mean([np.mean(one) for one in inside])),
            "half_width": float(np.mean([np.mean(one) for one in width])),
        }
    wrong = [
        (run["status"] == OK) & (np.abs(run["error"]) > HALF_WIDTHS * run["half_width"]).any(axis=1)
        for run in runs
    ]
    return Result(
        question.data,
        question.name,
        model,
        str(table["error_model"]["kind"]),
        question.unlike,
        axes,
        max(axis["worst"] for axis in axes.values()),
        float(np.mean([np.mean(run["status"] == UNTRAINED) for run in runs])),
        float(np.mean([np.mean(one) for one in wrong])),
    )


def _places(question: Question) -> range:
    return range(len(question.judged))


def _driven(model: Model, question: Question, place: int) -> dict[str, Any] | None:
    """Return what a compensator sends in one judged run, and what is left; None if it never starts.

    Faults count: while a sensor is broken, held and faded offsets are what the machine gets.
    """
    run = question.judged[place]
    drift = measured_drift(run, question.rig, TOOL_MM, model.input_form)
    time_s = run.time_s
    columns = [f"{sensor.name}_degC" for sensor in model.sensors]
    readings = run.frame[columns].to_numpy(float)
    known = "speed_rpm" in run.frame
    speed = run.frame["speed_rpm"].to_numpy(float) if known else np.full(len(time_s), np.nan)
    compensator = RunningCompensator(model)
    offsets, widths, statuses, kept = [], [], [], []
    last = -np.inf
    for row, time in enumerate(time_s):
        if time - last < STEP_S * 0.99:
            continue
        output = compensator.step(
            time, min(time - last, STEP_S), readings[row].tolist(), speed[row], TOOL_MM
        )
        last = time
        kept.append(row)
        offsets.append((output.dX, output.dY, output.dZ))
        widths.append((output.dX_uncertainty, output.dY_uncertainty, output.dZ_uncertainty))
        statuses.append(output.status)
    axes = [axis for axis in "XYZ" if f"drift_{axis}_um" in drift]
    at = ["XYZ".index(axis) for axis in axes]
    measured = drift[[f"drift_{axis}_um" for axis in axes]].to_numpy(float)[kept]
    status = np.array(statuses)
    usable = prepare([run], question.rig).runs[0].usable[kept]
    rows = np.isfinite(measured).all(axis=1) & usable & (status != 1)
    if not rows.any():
        return None
    return {
        "axes": axes,
        "drift": measured[rows],
        "error": measured[rows] + np.array(offsets)[rows][:, at],
        "half_width": np.array(widths)[rows][:, at],
        "status": status[rows],
    }
