"""Time series: ARX and ARMAX with inputs, ARMA without."""

from functools import cache
from typing import Any

import numpy as np
import pytest

from fmu_compensator.fit.data import prepare
from fmu_compensator.fit.error_models.mlr import MultipleLinearRegression
from fmu_compensator.fit.recipe import Recipe
from fmu_compensator.fit.training import TrainingRun
from measurement.errors import BadInput
from measurement.runs import Run
from studies.fit.arma import AutoregressiveMovingAverage
from studies.fit.arx import AutoregressiveExogenous
from tests.fmu_compensator.conftest import DIRECT_RIG, make_run
from tests.fmu_compensator.models.made import lag, rms, run_of, steps, task_of

# ARX


def arx_run(seed: int) -> TrainingRun:
    speed = steps(seed)
    temperature = lag(speed / 1000.0, 600.0)
    drift = 3.0 * lag(temperature, 3600.0)
    return run_of(temperature[:, None], drift[:, None], speed=speed, name=f"r{seed}")


@pytest.mark.parametrize(
    ("estimator", "step", "within"),
    [
        ("simulation", {}, 0.02),
        ("prediction", {}, 0.02),
        # A step may be longer than the sampling.
        ("simulation", {"step_s": 300.0}, 0.05),
        ("prediction", {"step_s": 300.0}, 0.05),
        ("armax", {"step_s": 300.0}, 0.05),
    ],
)
def test_arx_finds_the_memory(estimator, step, within):
    runs = [arx_run(seed) for seed in range(4)]
    fitted = AutoregressiveExogenous.fit(task_of(runs), estimator=estimator, **step)
    assert fitted.report()["memory_s"] == pytest.approx([3600.0], rel=0.02)
    unseen = arx_run(11)
    assert rms(unseen.targets - fitted.predict(unseen)) < within * rms(unseen.targets)
    static = MultipleLinearRegression.fit(task_of(runs))
    assert rms(unseen.targets - static.predict(unseen)) > 0.2 * rms(unseen.targets)


def test_a_measurement_takes_the_place_of_arx_own_prediction():
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


def armax(y: Any, x: Any) -> Any:
    """Return a, b, c and the variance of y(k) = a y(k-1) + b x(k) + e(k) + c e(k-1) by likelihood.

    In the state [y(k), c e(k)].
    """
    from statsmodels.tsa.statespace.mlemodel import MLEModel

    class Armax(MLEModel):
        start_params = (0.5, 1.0, 0.0, 0.1)

        def __init__(self) -> None:
            super().__init__(y, k_states=2, k_posdef=1)
            self.ahead = np.append(x[1:], 0.0)
            self["design"] = np.array([[1.0, 0.0]])
            self.ssm.initialize_approximate_diffuse()

        def update(self, params: Any, **given: Any) -> None:
            pole, now, moving, variance = super().update(params, **given)
            self["transition"] = np.array([[pole, 1.0], [0.0, 0.0]])
            self["selection"] = np.array([[1.0], [moving]])
            self["state_cov"] = np.array([[variance]])
            self["state_intercept"] = np.array([now * self.ahead, np.zeros(len(self.ahead))])

    return Armax().fit(disp=False).params


def test_armax_is_that_of_the_largest_likelihood():
    from scipy.signal import lfilter

    draw = np.random.default_rng(3).standard_normal
    x, error = lfilter([1.0], [1.0, -0.9], draw(3000)), draw(3000)
    y = lfilter([1.0], [1.0, -0.8], 0.5 * x + lfilter([1.0, -0.6], [1.0], error))
    ours = AutoregressiveExogenous.fit(
        task_of([run_of(x[:, None], y[:, None], name="r")]), estimator="armax", lags=0
    )
    theirs = armax(y, x)
    assert ours.report()["orders"]["y0"][2] >= 1
    assert ours.pole[0] == pytest.approx(theirs[0], abs=0.01)
    assert ours.now[0, 0] == pytest.approx(theirs[1], abs=0.02)
    assert theirs[2] == pytest.approx(-0.6, abs=0.1)


def before_run(seed: int, now: float, before: float) -> TrainingRun:
    temperature = np.random.default_rng(seed).standard_normal(300)
    drift = now * temperature + before * np.concatenate([temperature[:1], temperature[:-1]])
    drift += 0.1 * np.random.default_rng(50 + seed).standard_normal(300)
    return run_of(temperature[:, None], drift[:, None], name=f"b{seed}")


@pytest.mark.parametrize("runs", [1, 4])
def test_the_order_of_the_inputs_is_chosen(runs):
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


def test_an_unknown_estimator_or_order_is_refused():
    with pytest.raises(BadInput, match="'luck' is not allowed: simulation, prediction, armax"):
        AutoregressiveExogenous.fit(task_of([arx_run(0)]), estimator="luck")
    with pytest.raises(BadInput, match="lags: 7 is not allowed: 0, 1, choose"):
        AutoregressiveExogenous.fit(task_of([arx_run(0)]), lags=7)


# ARMA


def integrated_ar(seed: int, rows: int = 600, phi: float = 0.7) -> TrainingRun:
    random = np.random.default_rng(seed)
    w = np.zeros(rows)
    for k in range(1, rows):
        w[k] = phi * w[k - 1] + random.standard_normal()
    return run_of(random.standard_normal((rows, 1)), np.cumsum(w)[:, None])


@cache
def of_integrated_ar() -> AutoregressiveMovingAverage:
    return AutoregressiveMovingAverage.fit(task_of([integrated_ar(0)]))


def test_arma_differences_once_and_finds_the_coefficient():
    fitted = of_integrated_ar()
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


def test_a_run_that_is_sampled_too_coarsely_for_arma_is_named():
    made = [make_run(name, seed, hours=1.5, step_s=60.0) for seed, name in enumerate("ab")]
    made.append(make_run("coarse", 2, hours=1.5, step_s=600.0))
    axes = {"disp_x_um": "S1_um", "disp_z_um": "S5_um"}
    runs = [
        Run(run.name, run.frame.assign(**{name: run.frame[one] for name, one in axes.items()}))
        for run in made
    ]
    recipe = Recipe("arma", "T1,T4", "rise", {}, {"order": 1})
    prepared = prepare(runs, DIRECT_RIG, "rise")
    chosen, _ = recipe.choose(prepared, prepared.runs)
    notes = list(recipe.fit(prepared, prepared.runs, chosen).notes)
    assert notes == [
        "coarse is left out of the time series: no 30 steps in it without a gap of 300 s"
    ]


def test_arma_is_that_of_the_largest_of_several_likelihoods():
    from scipy.signal import lfilter
    from statsmodels.tsa.arima.model import ARIMA

    random = np.random.default_rng(5)
    w = lfilter([1.0, -1.12, 0.37], [1.0, -0.74], random.standard_normal(301))
    run = run_of(random.standard_normal((301, 1)), w[:, None])
    found = AutoregressiveMovingAverage.fit(task_of([run])).series[0].diagnostics["aic_by_order"]
    z = (w[:-1] - w[:-1].mean()) / w[:-1].std()
    theirs = ARIMA(z, order=(1, 0, 2), trend="n").fit().aic
    assert found["1,2"] == pytest.approx(theirs, abs=0.1)


def test_the_report_has_the_correlations_that_tell_the_kind_of_series():
    fitted = of_integrated_ar()
    [report] = fitted.report()["targets"].values()
    # An AR(1) of 0.7: the autocorrelation tails away as 0.7^k, the partial one breaks off after 1.
    bound = report["white_noise_95"]
    assert bound == pytest.approx(1.96 / np.sqrt(598), abs=5e-5)
    assert report["acf"][:4] == pytest.approx([1.0, 0.7, 0.49, 0.343], abs=0.1)
    assert report["pacf"][1] == pytest.approx(0.7, abs=0.1)
    assert sum(abs(value) > bound for value in report["pacf"][2:]) <= 3
    assert report["aic"] == min(report["aic_by_order"].values())


def test_one_step_ahead_beats_persistence_and_says_nothing_of_a_free_run():
    fitted = of_integrated_ar()
    unseen = integrated_ar(5)
    ahead = rms(unseen.targets - fitted.predict(unseen, unseen.targets))
    persistence = rms(np.diff(unseen.targets, axis=0))
    free = rms(unseen.targets - fitted.predict(unseen))
    assert 0.9 < ahead < 0.8 * persistence  # the noise has size 1: no forecast can do better
    assert free > 10 * ahead


def test_a_free_run_starts_from_zero_as_one_that_measures_does():
    run, fitted = integrated_ar(0), of_integrated_ar()
    once = np.full_like(run.targets, np.nan)
    once[0] = 0.0
    free = fitted.predict(run)
    assert free.tolist() == fitted.predict(run, once).tolist()
    assert np.abs(free).max() > 0.0


def test_a_forecast_uses_no_measurement_of_its_own_row_or_later():
    fitted = of_integrated_ar()
    unseen = integrated_ar(7, rows=200)
    changed = unseen.targets.copy()
    changed[120:] += 100.0
    plain, other = (fitted.predict(unseen, y) for y in (unseen.targets, changed))
    assert np.array_equal(plain[:121], other[:121])
    assert not np.allclose(plain[121], other[121])
