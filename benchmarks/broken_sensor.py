"""A sensor breaks: the error with what it is likely to read, and with hold and fade.

    python -m benchmarks.broken_sensor [--lathe DATA] [--write]

The jig borer: the compensator that ships, on a simulated run that it was not fitted on. Each of its
sensors breaks in turn, after two hours and for good, in three ways. The lathe: a compensator of its
runs of June and July, on the later ones in which the thermometer PT10 really jumps. All errors are
those from the fault on. `table` is what the page holds between its marks.
"""

from __future__ import annotations

import argparse
import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from benchmarks.results_page import tell
from benchmarks.trust.questions import lathe_runs
from fmu_compensator.fit.data import prepare
from fmu_compensator.fit.fitting import compensator_text, fit_compensator
from fmu_compensator.fit.training import Array
from fmu_compensator.runtime.compensator import SPARED, RunningCompensator
from fmu_compensator.runtime.modelfile import Model, load_model, parse_model
from measurement.drift import measured_drift
from measurement.rig import Rig, default_rig, rig_from_table
from measurement.runs import Run
from plant_model.machine_file import read_machine
from plant_model.simulate import simulate
from scenarios.machine_inputs import inputs_of
from scenarios.scenario import read_scenario

SHIPPED = Path(__file__).resolve().parents[1] / "fmu_compensator" / "library" / "jig_borer.json"
SCENARIO = "step_speed"
TOOL_MM = 100.0
BREAKS_S = 7200.0
EVERY_S = 30.0
LEARNT = "202008"
LATHE_MODEL = "gaussian"
"""What `fit` takes; it uses all sensors."""
HEAD = "| Run and fault | Axis | None | All good | Going on | Hold and fade | Within | Status 4 |"
FAULTS: dict[str, Callable[[Array], Array]] = {
    "missing": lambda values: np.full(len(values), np.nan),
    "stuck": lambda values: np.full(len(values), values[0]),
    "30 K off": lambda values: values + 30.0,
}


@dataclass(frozen=True)
class Judged:
    """What a compensator left in a run, from the fault on.

    Attributes
    ----------
    error, drift : array (n, axes)
        With and without the compensator [um].
    half_width : array (n, axes)
        Of the stated interval [um].
    spared : array (n,)
        Where the status is 4.
    """

    error: Array
    drift: Array
    half_width: Array
    spared: Array

    def rmse(self, axis: int) -> float:
        """Return the root mean square error along an axis [um]."""
        return float(np.sqrt(np.mean(self.error[:, axis] ** 2)))


def without_spare(model: Model) -> Model:
    """Return the same compensator, which knows no way to go on."""
    return replace(model, table={**model.table, "spare": None})


def drive(model: Model, run: Run, readings: Array, drift: Array, after_s: float) -> Judged:
    """Return what a compensator leaves of a run whose sensors show some readings.

    Parameters
    ----------
    model : Model
    run : Run
        For time and speed.
    readings : array (n, sensors of the file)
        [degC]
    drift : array (n, 3)
        Measured drift; NaN where it was not measured [um].
    after_s : float
        Rows from then on count [s].
    """
    compensator = RunningCompensator(model)
    known = "speed_rpm" in run.frame
    speed = run.frame["speed_rpm"].to_numpy(float) if known else np.full(len(drift), np.nan)
    rows, outputs = [], []
    last = run.time_s[0] - EVERY_S
    for row, time in enumerate(run.time_s.tolist()):
        if time - last < 0.99 * EVERY_S:
            continue
        values = readings[row].tolist()
        outputs.append(compensator.step(time, time - last, values, speed[row], TOOL_MM))
        rows.append(row)
        last = time
    axes = [axis for axis in range(3) if np.isfinite(drift[:, axis]).any()]
    measured = drift[rows][:, axes]
    use = np.isfinite(measured).all(axis=1) & (run.time_s[rows] >= after_s)
    offsets = np.array([output[:3] for output in outputs])[:, axes]
    widths = np.array([output[6:9] for output in outputs])[:, axes]
    spared = np.array([output.status == SPARED for output in outputs])
    return Judged((measured + offsets)[use], measured[use], widths[use], spared[use])


def drift_of(run: Run, model: Model, rig: Rig) -> Array:
    """Return the measured drift along X, Y, Z, shape (n, 3); NaN where it is not known [um]."""
    frame = measured_drift(run, rig, TOOL_MM, model.input_form)
    columns = [f"drift_{axis}_um" for axis in "XYZ"]
    lacking = np.full(len(frame), np.nan)
    return np.column_stack(
        [frame[name].to_numpy(float) if name in frame else lacking for name in columns]
    )


def readings_of(run: Run, model: Model) -> Array:
    """Return the temperatures of the file's sensors [degC]."""
    return run.frame[[f"{sensor.name}_degC" for sensor in model.sensors]].to_numpy(float)


def broken(run: Run, readings: Array, sensor: int, fault: str) -> Array:
    """Return the readings with a sensor that breaks after `BREAKS_S` [degC]."""
    found, late = readings.copy(), run.time_s >= BREAKS_S
    found[late, sensor] = FAULTS[fault](readings[late, sensor])
    return found


def jig_borer() -> tuple[Model, Run, Array, Array]:
    """Return the shipped compensator, an unseen run, its readings and its drift."""
    machine, case = read_machine("jig_borer"), read_scenario(SCENARIO).cases[0]
    result = simulate(machine, inputs_of(case, machine, EVERY_S), noise_seed=case.settings.seed)
    run = Run(SCENARIO, result.run_frame())
    model = load_model(SHIPPED)
    rig = rig_from_table(machine.rig, "rig")
    return model, run, readings_of(run, model), drift_of(run, model, rig)


def jig_borer_lines() -> Iterator[str]:
    """Yield the table's lines: each sensor breaks in turn."""
    model, run, readings, drift = jig_borer()
    plain = without_spare(model)
    good = drive(model, run, readings, drift, BREAKS_S)
    for fault in FAULTS:
        faulty = [broken(run, readings, place, fault) for place in model.chosen]
        on = [drive(model, run, values, drift, BREAKS_S) for values in faulty]
        held = [drive(plain, run, values, drift, BREAKS_S) for values in faulty]
        for number, axis in enumerate("XYZ"):
            name = f"jig borer, one of {len(faulty)} {fault}"
            yield _line(name, axis, number, [good], on, held)


def lathe_lines(folder: Path) -> Iterator[str]:
    """Yield the table's lines: what really broke on the lathe, in runs not learnt from."""
    runs = lathe_runs(folder)
    rig = default_rig(runs[0], read_machine("jig_borer").rig)
    train = [run for run in runs if run.name < LEARNT]
    fitted = fit_compensator(train, rig, LATHE_MODEL, points="all")
    model = parse_model(compensator_text(fitted), LATHE_MODEL)
    plain = without_spare(model)
    for run in (run for run in runs if run.name >= LEARNT):
        readings, drift = readings_of(run, model), drift_of(run, model, rig)
        drift[~prepare([run], rig).runs[0].usable] = np.nan
        on = drive(model, run, readings, drift, 0.0)
        if on.spared.any():
            held = drive(plain, run, readings, drift, 0.0)
            axes = [axis for axis in range(3) if np.isfinite(drift[:, axis]).any()]
            for number, axis in enumerate(axes):
                yield _line(f"lathe, {run.name}", "XYZ"[axis], number, [], [on], [held])


def _line(
    name: str,
    axis: str,
    number: int,
    good: Sequence[Judged],
    on: Sequence[Judged],
    held: Sequence[Judged],
) -> str:
    none = float(np.sqrt(np.mean(on[0].drift[:, number] ** 2)))
    within = np.mean(
        [np.mean(np.abs(one.error[:, number]) <= one.half_width[:, number]) for one in on]
    )
    spared = np.mean([np.mean(one.spared) for one in on])
    cells = [f"{none:.2f}", _worst(good, number), _worst(on, number), _worst(held, number)]
    return f"| {name} | {axis} | {' | '.join(cells)} | {within:.0%} | {spared:.0%} |"


def _worst(judged: Sequence[Judged], axis: int) -> str:
    """Return the median RMSE, and the largest in brackets where there are several [um]."""
    errors = [one.rmse(axis) for one in judged]
    if not errors:
        return ""
    if len(errors) == 1 or math.isclose(min(errors), max(errors)):
        return f"{errors[0]:.2f}"
    return f"{np.median(errors):.2f} ({max(errors):.2f})"


def table(lathe: Path | None) -> str:
    """Return the table's text."""
    lines = [HEAD, "| --- | --- |" + " ---: |" * 6, *jig_borer_lines()]
    if lathe is not None:
        lines += lathe_lines(lathe)
    return "\n".join(lines) + "\n"


def main() -> None:
    """Print the table, or put it into the page."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--lathe", type=Path, help="folder of the lathe's run files")
    parser.add_argument("--write", action="store_true", help="also write docs/results.md")
    args = parser.parse_args()
    tell("broken_sensor", table(args.lathe), write=args.write)


if __name__ == "__main__":
    main()
