"""The spindle speed as an input of the Gaussian: learnt, needed, and blamed."""

from math import nan
from pathlib import Path

import numpy as np
import pytest

from fmu_compensator.driving import drive
from fmu_compensator.fit.features import with_speed
from fmu_compensator.fit.fitting import compensator_text, fit_compensator
from fmu_compensator.fit.training import TrainingRun
from fmu_compensator.fit.updating import update_compensator
from fmu_compensator.monitoring.monitor import SENSOR, monitor
from fmu_compensator.runtime.compensator import (
    OK,
    SPARED,
    UNTRAINED,
    WAITING,
    RunningCompensator,
)
from fmu_compensator.runtime.modelfile import Model, parse_model
from measurement.errors import BadInput
from measurement.runs import Run
from scenarios.fit_text import report
from tests.fmu_compensator.conftest import RIG, make_run

RUNS = [make_run(f"run{seed}", seed, noise=0.3) for seed in range(5)]
NEW = make_run("new", 9, noise=0.3)
SECONDS, TOOL_MM = 60.0, 100.0


def fitted(runs: list[Run] = RUNS, **options: bool) -> Model:
    return parse_model(compensator_text(fit_compensator(runs, RIG, judge=False, **options)), "c")


@pytest.fixture(scope="module")
def model() -> Model:
    return fitted()


def without_speed(run: Run) -> Run:
    return Run(run.name, run.frame.drop(columns="speed_rpm"))


def left(model: Model, run: Run = NEW) -> float:
    return float(np.sqrt(np.nanmean(drive(model, run, run, RIG, TOOL_MM).error ** 2)))


def test_speed_tells_what_noisy_thermometers_do_not(model):
    blind = fitted(use_speed=False)
    assert model.uses_speed
    assert not blind.uses_speed
    assert left(model) < 0.6 * left(blind)
    assert "temperatures and speed, fitted to 5 runs" in model.title
    used = f"temperatures used: {', '.join(model.table['chosen'])}"
    assert f"{used}, and the spindle speed" in report(model.table, Path("c.json"))
    assert used in report(blind.table, Path("c.json"))


def test_the_unit_is_the_usual_speed_of_training(model):
    speeds = [np.abs(run.frame["speed_rpm"].to_numpy())[:-1] for run in RUNS]
    usual = np.sqrt(np.mean([np.append(0.0, speed) ** 2 for speed in speeds]))
    assert model.table["gaussian"]["speed_rpm"] == pytest.approx(usual)


def test_a_run_without_speed_leaves_it_out_and_a_note_says_so():
    model = fitted([*RUNS[:4], without_speed(RUNS[4])])
    assert not model.uses_speed
    assert "the spindle speed is not used: none in run4" in model.provenance["notes"]
    alike = fitted([without_speed(run) for run in RUNS])
    assert not any("speed" in note for note in alike.provenance["notes"])
    still = fitted([Run(run.name, run.frame.assign(speed_rpm=0.0)) for run in RUNS])
    assert not still.uses_speed


def test_one_of_many_runs_without_speed_is_judged_without_it():
    runs = [make_run(f"r{seed}", seed, hours=2.0, noise=0.3) for seed in range(6)]
    table = fit_compensator([*runs[:5], without_speed(runs[5])], RIG)
    assert table["provenance"]["figures"]["unseen"] is not None


def test_the_speed_does_not_count_where_drift_counts_from_fixed_temperatures():
    assert not fitted(input_form="absolute", points="T1,T4").uses_speed


def test_a_compensator_that_uses_speed_needs_it(model):
    for run in (without_speed(NEW), Run("new", NEW.frame.assign(speed_rpm=nan))):
        with pytest.raises(BadInput, match=r"new: column speed_rpm: holds no speed.*--no-speed"):
            drive(model, run, NEW, RIG, TOOL_MM)
        with pytest.raises(BadInput, match="column speed_rpm: holds no speed"):
            update_compensator(model, [run])


def test_an_update_learns_with_the_speed(model):
    table, _ = update_compensator(model, [make_run("more", 7, noise=0.3)])
    assert len(table["gaussian"]["weights"][0]) == len(model.table["gaussian"]["weights"][0])
    assert left(parse_model(compensator_text(table), "c")) < 1.5 * left(model)


def test_it_waits_for_a_first_speed_and_then_holds_the_last(model):
    compensator, warm = RunningCompensator(model), [20.0] * len(model.sensors)
    waiting = compensator.step(0.0, SECONDS, warm, nan, TOOL_MM)
    assert (waiting.status, waiting.status_sensor) == (WAITING, 0)
    assert waiting.status_text == "waiting for the first valid sample: speed is missing"
    twin = RunningCompensator(model)
    for step in range(1, 60):
        time, speed = step * SECONDS, 3000.0 if step < 20 else nan
        output = compensator.step(time, SECONDS, warm, speed, TOOL_MM)
        assert output[:3] == twin.step(time, SECONDS, warm, -3000.0, TOOL_MM)[:3]
    assert (output.valid, output.status, output.status_sensor) == (True, SPARED, 0)
    assert output.status_text == "going on without a sensor: speed is missing"
    assert compensator.step(3600.0, SECONDS, warm, 3000.0, TOOL_MM).status != SPARED


def test_a_speed_far_above_training_is_new_and_blamed(model):
    compensator, cold = RunningCompensator(model), [20.0] * len(model.sensors)
    usual = compensator.step(0.0, SECONDS, cold, 1000.0, TOOL_MM)
    assert usual.status in (OK, 3)
    for step in range(1, 60):
        output = compensator.step(step * SECONDS, SECONDS, cold, 40_000.0, TOOL_MM)
    assert (output.status, output.status_sensor) == (UNTRAINED, 0)
    assert output.status_text.startswith("conditions outside training make ")
    assert ": speed" in output.status_text


def test_at_an_impossible_speed_the_last_known_one_holds(model):
    cold, offsets = [20.0] * len(model.sensors), []
    for read in (1000.0, 1e6, -1e6, 11.0 * model.table["gaussian"]["speed_rpm"]):
        compensator = RunningCompensator(model)
        for step, speed in enumerate((1000.0, read, 1000.0, 1000.0)):
            output = compensator.step(step * SECONDS, SECONDS, cold, speed, TOOL_MM)
        offsets.append(output[:3])
    assert offsets[1:] == offsets[:1] * 3
    first = RunningCompensator(model).step(0.0, SECONDS, cold, 1e6, TOOL_MM)
    assert (first.status, first.status_text[-16:]) == (WAITING, "speed is missing")


def test_a_log_with_a_missing_speed_does_not_blame_a_thermometer(model):
    third = np.arange(len(NEW.frame)) // (len(NEW.frame) // 3) == 1
    gap = Run("gap", NEW.frame.assign(speed_rpm=NEW.frame["speed_rpm"].mask(third)))
    (report,) = monitor(model, [gap]).runs
    assert report.verdict != SENSOR
    assert any(reason.startswith("speed is missing in 3") for reason in report.reasons)


def test_a_fit_holds_the_last_speed_like_the_compensator(model):
    unit = model.table["gaussian"]["speed_rpm"]
    speed = np.array([np.nan, 1000.0, 11.0 * unit, np.nan, -2000.0, 0.0, 0.0])
    nothing = np.zeros((len(speed), 1))
    run = TrainingRun("r", np.arange(7.0), nothing, nothing, speed, np.ones(len(speed)))
    turning = with_speed(run, nothing, unit)[:, 1] * unit
    assert turning == pytest.approx([0.0, 0.0, 1000.0, 1000.0, 1000.0, 2000.0, 0.0])
