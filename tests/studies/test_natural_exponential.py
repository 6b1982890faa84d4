"""The natural exponential, its numbers from runs or from finite elements."""

from dataclasses import replace

import numpy as np
import pytest

from fmu_compensator.fit.training import TrainingRun
from measurement.errors import BadInput
from studies.finite_elements import FiniteElementSpindle
from studies.fit.ne import NaturalExponential
from tests.fmu_compensator.models.made import lag, rms, run_of, steps, task_of
from tests.refusing import refusal


def exponential_run(seed: int) -> TrainingRun:
    speed = steps(seed)
    drift = lag(0.002 * speed, 1500.0)
    return run_of(
        np.random.default_rng(seed).standard_normal((len(speed), 1)), drift[:, None], speed=speed
    )


@pytest.mark.parametrize("every", [1, 10])
def test_the_natural_exponential_is_found_again(every):
    """Also where drift is measured seldom."""
    runs = [exponential_run(seed) for seed in range(3)]
    for run in runs:
        run.targets[np.arange(len(run.time_s)) % every != every // 3] = np.nan
    fitted = NaturalExponential.fit(task_of(runs))
    assert fitted.tau_s == pytest.approx([1500.0], rel=0.02)
    assert fitted.speeds_rpm.tolist() == [3000.0, 6000.0, 12000.0]
    assert fitted.steady[0] == pytest.approx([6.0, 12.0, 24.0], rel=0.02)
    unseen = exponential_run(9)
    assert rms(unseen.targets - fitted.predict(unseen)) < 0.02 * rms(unseen.targets)


def test_a_measured_speed_may_fluctuate():
    runs = [exponential_run(seed) for seed in range(3)]
    for run in runs:
        # At standstill the reading is not quite 0; still air cools half as fast.
        for k in range(1, len(run.time_s)):
            tau = 1500.0 if run.speed[k - 1] else 3000.0
            goal = 0.002 * run.speed[k - 1]
            run.targets[k] = goal + (run.targets[k - 1] - goal) * np.exp(-60.0 / tau)
        random = np.random.default_rng(5).uniform(-1.0, 1.0, len(run.speed))
        run.speed[:] += np.where(run.speed > 0.0, 20.0, 0.5) * random
    fitted = NaturalExponential.fit(task_of(runs))
    assert fitted.speeds_rpm == pytest.approx([3000.0, 6000.0, 12000.0], rel=0.002)
    assert fitted.steady[0] == pytest.approx([6.0, 12.0, 24.0], rel=0.02)
    assert fitted.tau_s == pytest.approx([1500.0], rel=0.02)
    assert fitted.tau_stopped_s == pytest.approx([3000.0], rel=0.02)


def test_a_restart_goes_on_from_where_it_stands():
    fitted = NaturalExponential(
        np.array([1000.0]), np.array([[10.0]]), np.array([600.0]), np.array([1200.0])
    )
    time = np.arange(0.0, 7201.0, 100.0)
    speed = np.where(time < 1800.0, 1000.0, np.where(time < 2400.0, 0.0, 1000.0))
    run = run_of(np.zeros((len(time), 1)), np.zeros((len(time), 1)), speed=speed, time_s=time)
    drift = fitted.predict(run)[:, 0]
    hot = 10.0 * (1 - np.exp(-1800.0 / 600.0))
    stopped = hot * np.exp(-600.0 / 1200.0)
    again = 10.0 + (stopped - 10.0) * np.exp(-600.0 / 600.0)
    for moment, wanted in ((0.0, 0.0), (1800.0, hot), (2400.0, stopped), (3000.0, again)):
        assert drift[time == moment] == pytest.approx([wanted], rel=1e-12)


def test_the_natural_exponential_needs_a_speed():
    run = exponential_run(0)
    without = run_of(run.inputs, run.targets)
    assert "speed_rpm: is not known" in refusal(NaturalExponential.fit, task_of([without]))
    still = run_of(run.inputs, run.targets, speed=np.zeros(len(run.speed)))
    assert "never above 0" in refusal(NaturalExponential.fit, task_of([still]))


def test_the_time_constant_follows_from_mass_heat_film_and_surface():
    runs = [exponential_run(seed) for seed in range(3)]
    body = {"mass_kg": 10.0, "specific_heat": 470.0, "film": 25.0, "surface_m2": 0.1}
    fitted = NaturalExponential.fit(task_of(runs), **body)
    assert fitted.tau_s == pytest.approx([10.0 * 470.0 / (25.0 * 0.1)])
    assert fitted.tau_stopped_s == pytest.approx(fitted.tau_s)
    given = NaturalExponential.fit(task_of(runs), tau_s=1500.0)
    assert given.steady[0] == pytest.approx([6.0, 12.0, 24.0], rel=1e-3)
    assert rms(runs[0].targets - given.predict(runs[0])) < rms(
        runs[0].targets - fitted.predict(runs[0])
    )
    with pytest.raises(BadInput, match="surface_m2: is missing"):
        NaturalExponential.fit(task_of(runs), mass_kg=10.0, specific_heat=470.0, film=25.0)
    with pytest.raises(BadInput, match="tau_s: cannot stand beside mass_kg"):
        NaturalExponential.fit(task_of(runs), tau_s=1500.0, **body)
    with pytest.raises(BadInput, match="tau_s: 'slow' is not allowed"):
        NaturalExponential.fit(task_of(runs), tau_s="slow")


def test_steady_growth_and_time_constants_come_from_finite_elements():
    spindle = FiniteElementSpindle()
    time = 60.0 * np.arange(300)
    speed = steps(3)
    growth = spindle.transient(time, speed, 20.0, 20.0).growth_um
    run = run_of(np.ones((300, 1)), np.column_stack([growth, 0.5 * growth]), speed=speed)
    run.inputs[:, 0] = np.arange(300)
    task = replace(task_of([run]), target_names=["elongation", "yaw"])
    fitted = NaturalExponential.fit(task, steady="fem", tau_s="fem")
    wanted = [spindle.zss(n) for n in fitted.speeds_rpm]
    # Growth is taken as it is; what has no steady state of its own is in proportion to it.
    assert fitted.steady[0] == pytest.approx(wanted)
    assert fitted.steady[1] == pytest.approx(0.5 * fitted.steady[0], rel=0.1)
    assert rms(run.targets[:, 0] - fitted.predict(run)[:, 0]) < 0.15 * np.ptp(growth)
    # After one time constant from rest a step has come within 1/e of its end.
    mean = float(speed[speed > 1.0].mean())
    step = spindle.transient(time, np.full(300, mean), 20.0, 20.0).growth_um
    left = 1.0 - np.interp(fitted.tau_s[0], time, step) / spindle.zss(mean)
    assert left == pytest.approx(np.exp(-1.0), abs=0.005)
