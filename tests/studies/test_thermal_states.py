"""Models on lags of the temperatures: thermal states, ridge, LASSO."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from fmu_compensator.fit.error_models.mlr import MultipleLinearRegression
from fmu_compensator.fit.training import TrainingRun
from studies.fit.bayes import Bayes
from studies.fit.lagged import features
from studies.fit.lasso import Lasso
from studies.fit.ridge import Ridge
from studies.fit.thermal_states import ThermalStates
from tests.fmu_compensator.models.made import lag, rms, run_of, steps, task_of
from tests.refusing import refusal

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


def test_thermal_states_follow_what_a_static_map_cannot():
    runs = [hysteresis_run(seed) for seed in range(8)]
    fitted = ThermalStates.fit(task_of(runs, "level"))
    unseen = [hysteresis_run(seed) for seed in (20, 21)]
    missed = rms(np.concatenate([run.targets - fitted.predict(run) for run in unseen]))
    raw = rms(np.concatenate([run.targets for run in unseen]))
    static = MultipleLinearRegression.fit(task_of(runs, "level"))
    static_missed = rms(np.concatenate([run.targets - static.predict(run) for run in unseen]))
    assert missed < 0.1 * raw
    assert missed < 0.3 * static_missed


def test_what_is_solved_for_is_what_runs():
    """The regressors are the fit's own; the runtime's equation must weigh the same."""
    fitted = ThermalStates.fit(task_of([hysteresis_run(seed) for seed in range(8)], "level"))
    run = hysteresis_run(3)
    wanted = features(run, fitted.lags_s, uses_speed=True, uses_levels=True) @ fitted.coefficients.T
    assert fitted.predict(run) == pytest.approx(wanted, abs=1e-9)


def test_a_run_that_the_others_do_not_explain_is_trusted_less():
    runs = [hysteresis_run(seed) for seed in range(7)] + [hysteresis_run(7, gain=4.0)]
    unseen = hysteresis_run(30)
    robust, plain = (
        ThermalStates.fit(task_of(runs, "level"), robust=robust) for robust in (True, False)
    )
    trust = robust.report()["targets"]["y0"]["trust"]
    assert trust["r7"] < 0.2 * np.median(list(trust.values()))
    errors = [rms(unseen.targets - model.predict(unseen)) for model in (robust, plain)]
    assert errors[0] < 0.5 * errors[1]


@pytest.mark.parametrize("kind", [ThermalStates, Bayes])
def test_trust_is_told_by_the_runs_it_is_of(kind):
    """One of two rows makes no block, and gives its name to none."""
    runs = [hysteresis_run(seed) for seed in range(4)]
    short = replace(runs[0], name="short")
    runs.insert(0, short.at(np.arange(len(short.time_s)) < 2))
    runs = [replace(run, name=f"run{place}") for place, run in enumerate(runs)]
    told = kind.fit(task_of(runs, "level")).report()
    trust = told["trust"] if kind is Bayes else told["targets"]["y0"]["trust"]
    names = list(trust)
    assert names == [run.name for run in runs if len(run.time_s) > 2]


def test_rows_without_targets_still_count_as_history():
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


@pytest.mark.parametrize(
    ("options", "told"),
    [
        ({"lags_s": (1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0)}, "6 time constants at most"),
        ({"lags_s": (0.0,)}, "lags_s: 0 is not allowed"),
        ({"penalty": 0.0}, "penalty: 0 is not allowed"),
        ({"walk": -1.0}, "walk: -1 is not allowed"),
    ],
)
def test_wrong_options_are_refused(options, told):
    assert told in refusal(ThermalStates.fit, task_of([hysteresis_run(0)], "level"), **options)


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
def test_a_regression_on_lags_finds_the_lagged_sensor(kind):
    fitted = kind.fit(task_of([copies_run(seed) for seed in range(5)]))
    unseen = copies_run(30)
    assert rms(unseen.targets - fitted.predict(unseen)) < 0.05 * rms(unseen.targets)
    table = fitted.table()
    assert not np.any(table["speed_lags"])
    assert not np.any(table["level_lags"])


def test_lasso_solves_its_own_problem():
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
