"""Models with a memory: natural exponential, ARX, ARMA, thermal states."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from fmu_compensator.fit.by_run import Solution
from fmu_compensator.fit.error_models.arma import AutoregressiveMovingAverage
from fmu_compensator.fit.error_models.arx import AutoregressiveExogenous
from fmu_compensator.fit.error_models.lasso import Lasso
from fmu_compensator.fit.error_models.mlr import MultipleLinearRegression
from fmu_compensator.fit.error_models.ne import NaturalExponential
from fmu_compensator.fit.error_models.ridge import Ridge
from fmu_compensator.fit.error_models.thermal_states import (
    WORTH,
    LagChoice,
    ThermalStates,
    averaged,
)
from fmu_compensator.fit.finite_elements import FiniteElementSpindle
from fmu_compensator.fit.lagged import features
from fmu_compensator.fit.training import TrainingRun
from measurement.errors import BadInput
from tests.fmu_compensator.models.made import lag, run_of, steps, task_of


def rms(values: Any) -> float:
    return float(np.sqrt(np.nanmean(np.square(values))))


# Natural exponential


def exponential_run(seed: int) -> TrainingRun:
    speed = steps(seed)
    drift = lag(0.002 * speed, 1500.0)
    return run_of(
        np.random.default_rng(seed).standard_normal((len(speed), 1)), drift[:, None], speed=speed
    )


def test_the_natural_exponential_is_found_again() -> None:
    fitted = NaturalExponential.fit(task_of([exponential_run(seed) for seed in range(3)]))
    assert fitted.tau_s == pytest.approx([1500.0], rel=0.02)
    assert fitted.speeds_rpm.tolist() == [3000.0, 6000.0, 12000.0]
    assert fitted.steady[0] == pytest.approx([6.0, 12.0, 24.0], rel=0.02)
    unseen = exponential_run(9)
    assert rms(unseen.targets - fitted.predict(unseen)) < 0.02 * rms(unseen.targets)


def test_a_restart_goes_on_from_where_it_stands() -> None:
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


def test_the_natural_exponential_needs_a_speed() -> None:
    run = exponential_run(0)
    without = run_of(run.inputs, run.targets)
    with pytest.raises(BadInput, match="speed_rpm: is missing"):
        NaturalExponential.fit(task_of([without]))
    still = run_of(run.inputs, run.targets, speed=np.zeros(len(run.speed)))
    with pytest.raises(BadInput, match="never above 0"):
        NaturalExponential.fit(task_of([still]))


def test_the_time_constant_follows_from_mass_heat_film_and_surface() -> None:
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


def test_steady_growth_and_time_constants_come_from_finite_elements() -> None:
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
    assert left == pytest.approx(np.exp(-1.0), abs=0.06)


# ARX


def arx_run(seed: int) -> TrainingRun:
    speed = steps(seed)
    temperature = lag(speed / 1000.0, 600.0)
    drift = 3.0 * lag(temperature, 3600.0)
    return run_of(temperature[:, None], drift[:, None], speed=speed, name=f"r{seed}")


@pytest.mark.parametrize("estimator", ["simulation", "prediction"])
def test_arx_finds_the_memory(estimator: str) -> None:
    fitted = AutoregressiveExogenous.fit(
        task_of([arx_run(seed) for seed in range(4)]), estimator=estimator
    )
    assert fitted.report()["memory_s"] == pytest.approx([3600.0], rel=0.02)
    unseen = arx_run(11)
    assert rms(unseen.targets - fitted.predict(unseen)) < 0.02 * rms(unseen.targets)
    static = MultipleLinearRegression.fit(task_of([arx_run(seed) for seed in range(4)]))
    assert rms(unseen.targets - static.predict(unseen)) > 0.2 * rms(unseen.targets)


def test_a_measurement_takes_the_place_of_arx_own_prediction() -> None:
    fitted = AutoregressiveExogenous.fit(task_of([arx_run(seed) for seed in range(4)]))
    unseen = arx_run(12)
    shifted = unseen.targets + 5.0
    measured = np.full_like(shifted, np.nan)
    measured[100] = shifted[100]
    free, told = fitted.predict(unseen), fitted.predict(unseen, measured)
    assert np.array_equal(free[:101], told[:101])
    gap = (told - free)[101:, 0]
    assert gap[0] == pytest.approx(5.0 * fitted.pole[0], abs=0.3)
    assert gap[-1] == pytest.approx(0.0, abs=0.3)


def noisy_arx_run(seed: int) -> TrainingRun:
    run = arx_run(seed)
    noise = np.random.default_rng(100 + seed).standard_normal(run.targets.shape)
    return run_of(run.inputs, run.targets + noise, speed=run.speed, name=run.name)


def test_armax_takes_off_what_sensor_noise_does_to_the_memory() -> None:
    # With white noise v on the drift, y(k) = a y(k-1) + ... + v(k) - a v(k-1): an ARMAX.
    task = task_of([noisy_arx_run(seed) for seed in range(8)])
    plain, armax = (
        AutoregressiveExogenous.fit(task, estimator=name) for name in ("prediction", "armax")
    )
    assert armax.report()["orders"]["y0"][2] >= 1
    assert plain.report()["orders"]["y0"][2] == 0
    memories = [float(model.report()["memory_s"][0]) for model in (plain, armax)]
    assert memories[0] < 0.6 * 3600.0
    assert memories[1] == pytest.approx(3600.0, rel=0.25)
    unseen = arx_run(11)
    missed = [rms(unseen.targets - model.predict(unseen)) for model in (plain, armax)]
    assert missed[1] < 0.5 * missed[0]


def before_run(seed: int, now: float, before: float) -> TrainingRun:
    temperature = np.random.default_rng(seed).standard_normal(300)
    drift = now * temperature + before * np.concatenate([temperature[:1], temperature[:-1]])
    drift += 0.1 * np.random.default_rng(50 + seed).standard_normal(300)
    return run_of(temperature[:, None], drift[:, None], name=f"b{seed}")


@pytest.mark.parametrize("runs", [1, 4])
def test_the_order_of_the_inputs_is_chosen(runs: int) -> None:
    with_past, without = (
        AutoregressiveExogenous.fit(
            task_of([before_run(seed, 2.0, before) for seed in range(runs)]), lags="choose"
        )
        for before in (1.0, 0.0)
    )
    assert with_past.report()["orders"] == {"y0": [0, 1, 0]}
    assert without.report()["orders"] == {"y0": [0, 0, 0]}
    assert not without.before.any()
    assert with_past.before == pytest.approx(np.array([[1.0]]), abs=0.05)


def test_an_unknown_estimator_or_order_is_refused() -> None:
    with pytest.raises(BadInput, match="'luck' is not allowed: simulation, prediction, armax"):
        AutoregressiveExogenous.fit(task_of([arx_run(0)]), estimator="luck")
    with pytest.raises(BadInput, match="lags: 7 is not allowed: 0, 1, choose"):
        AutoregressiveExogenous.fit(task_of([arx_run(0)]), lags=7)


# Time series


def integrated_ar(seed: int, rows: int = 1200, phi: float = 0.7) -> TrainingRun:
    random = np.random.default_rng(seed)
    w = np.zeros(rows)
    for k in range(1, rows):
        w[k] = phi * w[k - 1] + random.standard_normal()
    return run_of(random.standard_normal((rows, 1)), np.cumsum(w)[:, None])


def test_arma_differences_once_and_finds_the_coefficient() -> None:
    fitted = AutoregressiveMovingAverage.fit(task_of([integrated_ar(0)]))
    series = fitted.series[0]
    assert series.differences == 1
    p_values = series.diagnostics["adf_p"]
    assert p_values[0] > 0.05 > p_values[1]
    # phi alone, or phi and what little else chance has AIC add.
    impulse = np.zeros(8)
    impulse[0] = 1.0
    for k in range(1, 8):
        impulse[k] = sum(a * impulse[k - 1 - i] for i, a in enumerate(series.ar[:k]))
        impulse[k] += series.ma[k - 1] if k <= len(series.ma) else 0.0
    assert impulse[:4] == pytest.approx([1.0, 0.7, 0.49, 0.343], abs=0.1)


def test_the_report_has_the_correlations_that_tell_the_kind_of_series() -> None:
    fitted = AutoregressiveMovingAverage.fit(task_of([integrated_ar(0)]))
    [report] = fitted.report()["targets"].values()
    # An AR(1) of 0.7: the autocorrelation tails away as 0.7^k, the partial one breaks off after 1.
    bound = report["white_noise_95"]
    assert bound == pytest.approx(1.96 / np.sqrt(1199), rel=1e-3)
    assert report["acf"][:4] == pytest.approx([1.0, 0.7, 0.49, 0.343], abs=0.1)
    assert report["pacf"][1] == pytest.approx(0.7, abs=0.1)
    assert sum(abs(value) > bound for value in report["pacf"][2:]) <= 3
    assert report["aic"] == min(report["aic_by_order"].values())


def test_every_row_counts_in_a_series() -> None:
    # The first 600 rows are one series, the rest another: only all of them tell.
    first, rest = integrated_ar(1, rows=600, phi=0.1), integrated_ar(2, rows=2400, phi=0.9)
    joined = np.concatenate([first.targets, first.targets[-1] + rest.targets])
    run = run_of(np.random.default_rng(0).standard_normal((3000, 1)), joined)
    [report] = AutoregressiveMovingAverage.fit(task_of([run])).report()["targets"].values()
    assert report["acf"][1] > 0.8


def test_one_step_ahead_beats_persistence_and_says_nothing_of_a_free_run() -> None:
    fitted = AutoregressiveMovingAverage.fit(task_of([integrated_ar(0)]))
    unseen = integrated_ar(5)
    ahead = rms(unseen.targets - fitted.predict(unseen, unseen.targets))
    persistence = rms(np.diff(unseen.targets, axis=0))
    free = rms(unseen.targets - fitted.predict(unseen))
    assert 0.9 < ahead < 0.8 * persistence  # the noise has size 1: no forecast can do better
    assert free > 10 * ahead


def test_probing_now_and_then_pulls_the_series_back() -> None:
    fitted = AutoregressiveMovingAverage.fit(task_of([integrated_ar(0)]))
    unseen = integrated_ar(6)
    probed = np.full_like(unseen.targets, np.nan)
    probed[::50] = unseen.targets[::50]
    now_and_then = rms(unseen.targets - fitted.predict(unseen, probed))
    always = rms(unseen.targets - fitted.predict(unseen, unseen.targets))
    assert always < now_and_then < 0.5 * rms(unseen.targets - fitted.predict(unseen))


def test_a_forecast_uses_no_measurement_of_its_own_row_or_later() -> None:
    fitted = AutoregressiveMovingAverage.fit(task_of([integrated_ar(0)]))
    unseen = integrated_ar(7, rows=200)
    changed = unseen.targets.copy()
    changed[120:] += 100.0
    plain, other = (fitted.predict(unseen, y) for y in (unseen.targets, changed))
    assert np.array_equal(plain[:121], other[:121])
    assert not np.allclose(plain[121], other[121])


# Thermal states


def hysteresis_run(seed: int, *, start: float = 20.0, gain: float = 1.0) -> TrainingRun:
    """A fast sensor, a slow one, and a drift that lags both; hall temperature sets the level."""
    random = np.random.default_rng(seed)
    speed = steps(seed, rows=360)
    heat = speed / 2000.0
    fast, slow = lag(heat, 500.0), lag(heat, 2500.0)
    bias = random.uniform(-1.0, 1.0)  # the hall against the machine at the start
    bath = np.full(len(heat), bias)
    levels = start + np.column_stack([fast, slow, bath])
    levels += 0.01 * random.standard_normal(levels.shape)
    drift = gain * (4.0 * lag(slow, 3600.0) + 2.0 * lag(bath, 3600.0))
    drift += 0.05 * random.standard_normal(len(drift))
    return run_of(levels, (drift - drift[0])[:, None], speed=speed, name=f"r{seed}")


def test_thermal_states_follow_what_a_static_map_cannot() -> None:
    runs = [hysteresis_run(seed) for seed in range(8)]
    fitted = ThermalStates.fit(task_of(runs, "level"))
    unseen = [hysteresis_run(seed) for seed in (20, 21)]
    missed = rms(np.concatenate([run.targets - fitted.predict(run) for run in unseen]))
    raw = rms(np.concatenate([run.targets for run in unseen]))
    static = MultipleLinearRegression.fit(task_of(runs, "level"))
    static_missed = rms(np.concatenate([run.targets - static.predict(run) for run in unseen]))
    assert missed < 0.1 * raw
    assert missed < 0.3 * static_missed


def test_a_sensor_that_reads_high_in_a_new_run_does_no_harm() -> None:
    fitted = ThermalStates.fit(task_of([hysteresis_run(seed) for seed in range(8)], "level"))
    unseen = hysteresis_run(20)
    jumped = unseen.inputs.copy()
    jumped[:, 2] += 31.0
    other = run_of(jumped, unseen.targets, speed=unseen.speed)
    difference = rms(fitted.predict(other) - fitted.predict(unseen))
    assert difference < 0.3 * rms(unseen.targets)
    fine = run_of(unseen.inputs + 5.0, unseen.targets, speed=unseen.speed)
    assert fitted.predict(fine) == pytest.approx(fitted.predict(unseen), abs=1e-6)


def test_a_run_that_the_others_do_not_explain_is_trusted_less() -> None:
    runs = [hysteresis_run(seed) for seed in range(7)] + [hysteresis_run(7, gain=4.0)]
    unseen = hysteresis_run(30)
    robust, plain = (
        ThermalStates.fit(task_of(runs, "level"), robust=robust) for robust in (True, False)
    )
    trust = robust.report()["targets"]["y0"]["trust"]
    assert trust["r7"] < 0.2 * np.median(list(trust.values()))
    errors = [rms(unseen.targets - model.predict(unseen)) for model in (robust, plain)]
    assert errors[0] < 0.5 * errors[1]


def test_rows_without_targets_still_count_as_history() -> None:
    run = hysteresis_run(20)
    gap = run.targets.copy()
    gap[100:200] = np.nan
    runs = [hysteresis_run(seed) for seed in range(4)]
    options: dict[str, Any] = {"lags_s": (3600.0,), "penalty": 1e-6, "walk": 0.0, "speed": False}
    with_gap = run_of(run.inputs, gap, speed=run.speed, name="gap")
    whole, gappy = (
        ThermalStates.fit(task_of([*runs, last], "level"), **options) for last in (run, with_gap)
    )
    unseen = hysteresis_run(21)
    assert rms(gappy.predict(unseen) - whole.predict(unseen)) < 0.05 * rms(unseen.targets)


def test_a_measured_bias_is_taken_up_and_kept() -> None:
    fitted = ThermalStates.fit(task_of([hysteresis_run(seed) for seed in range(4)], "level"))
    unseen = hysteresis_run(22)
    measured = np.full_like(unseen.targets, np.nan)
    measured[100] = fitted.predict(unseen)[100] + 6.0
    moved = (fitted.predict(unseen, measured) - fitted.predict(unseen))[:, 0]
    assert (moved[:101] == 0.0).all()
    assert 0.0 < moved[101] <= 6.0
    assert moved[101:] == pytest.approx(moved[101])


@pytest.mark.parametrize(
    ("options", "told"),
    [
        ({"lags_s": ()}, "1 to 6 time constants"),
        ({"lags_s": (0.0,)}, "lags_s: 0 is not allowed"),
        ({"penalty": 0.0}, "penalty: 0 is not allowed"),
        ({"walk": -1.0}, "walk: -1 is not allowed"),
    ],
)
def test_wrong_options_are_refused(options: dict[str, Any], told: str) -> None:
    with pytest.raises(BadInput, match=told):
        ThermalStates.fit(task_of([hysteresis_run(0)], "level"), **options)


# Ridge and LASSO


def copies_run(seed: int) -> TrainingRun:
    """Twelve sensors of which the first alone, and late, makes the drift."""
    random = np.random.default_rng(seed)
    source = lag(steps(seed, rows=300) / 1000.0, 600.0)
    others = np.cumsum(0.05 * random.standard_normal((300, 11)), axis=0)
    rises = np.column_stack([source, others])
    drift = 3.0 * lag(source, 2400.0) + 0.05 * random.standard_normal(300)
    return run_of(rises - rises[0], (drift - drift[0])[:, None], speed=steps(seed, rows=300))


@pytest.mark.parametrize("kind", [Ridge, Lasso])
def test_a_regression_on_lags_finds_the_lagged_sensor(kind: type[ThermalStates]) -> None:
    fitted = kind.fit(task_of([copies_run(seed) for seed in range(5)]))
    unseen = copies_run(30)
    assert rms(unseen.targets - fitted.predict(unseen)) < 0.05 * rms(unseen.targets)
    table = fitted.table()
    assert not np.any(table["speed_lags"])
    assert not np.any(table["level_lags"])


def test_lasso_leaves_most_inputs_out_and_ridge_none() -> None:
    task = task_of([copies_run(seed) for seed in range(5)])
    used = {}
    for kind in (Ridge, Lasso):
        table = kind.fit(task, lags_s=(600.0, 2400.0)).table()
        weights = np.concatenate([np.ravel(table["direct"]), np.ravel(table["rise_lags"])])
        used[kind] = int((weights != 0.0).sum())
    assert used[Ridge] == 36
    assert used[Lasso] < 18


def test_lasso_solves_its_own_problem() -> None:
    # Where a weight is not zero, its slope is the penalty; elsewhere it is smaller.
    run = copies_run(3)
    options = {"lags_s": (2400.0,), "penalty": 0.05}
    fitted = Lasso.fit(task_of([run]), **options)
    x = features(run, (2400.0,), uses_speed=False, uses_levels=False)[::5]
    y = run.targets[::5, 0]
    size = np.sqrt(np.mean(x**2, axis=0))
    moving = size > 0
    slope = (x[:, moving] / size[moving]).T @ (y - x @ fitted.coefficients[0]) / len(x)
    largest = np.abs((x[:, moving] / size[moving]).T @ y).max() / len(x)
    active = fitted.coefficients[0][moving] != 0.0
    assert 0 < active.sum() < active.size
    assert np.abs(slope[active]) == pytest.approx(0.05 * largest, rel=1e-3)
    assert (np.abs(slope[~active]) <= 0.05 * largest * 1.001).all()


def test_the_shares_of_the_average_fall_with_the_error() -> None:
    found = [
        LagChoice((1.0,), False, 0.0, False, 1.0, Solution(np.zeros(1), np.ones(2), rms))
        for rms in (np.full(2, 1.0), np.full(2, 1.1), np.full(2, 3.0))
    ]
    mix = averaged(found)
    assert sum(share for share, _ in mix) == pytest.approx(1.0)
    assert [one for _, one in mix] == found[:2]
    assert mix[1][0] / mix[0][0] == pytest.approx(np.exp(-np.log(1.1) / WORTH))
