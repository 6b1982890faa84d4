"""The Gaussian, fitted and at run time, beside regression with the covariance of all rows."""

import json
from dataclasses import replace
from math import inf, nan
from typing import Any

import numpy as np
import pytest

from fmu_compensator.fit import gaussian as fitting
from fmu_compensator.fit.features import Sample, with_lags
from fmu_compensator.fit.gaussian import Gaussian, by_feature, directions
from fmu_compensator.runtime.fields import Fields
from fmu_compensator.runtime.gaussian import Gaussian as Installed
from tests.fmu_compensator.dense import LAGS_S, Array, Dense, drawn
from tests.fmu_compensator.gaussians import knows_nothing
from tests.refusing import refusal

INPUTS, WALK = 2, 0.7
WIDTH = INPUTS * (1 + len(LAGS_S))
WEIGHTS = np.random.default_rng(1).normal(0.0, 0.8, (WIDTH, 2))
SAMPLES = [drawn(seed, WEIGHTS, walk=WALK) for seed in range(3)]
FURTHER = [drawn(10 + seed, WEIGHTS, walk=WALK) for seed in range(3)]
NEW = drawn(99, WEIGHTS, walk=WALK, rows=40)


@pytest.fixture
def walks_alike(monkeypatch: pytest.MonkeyPatch) -> None:
    """Every run's walk is of the usual size, and every direction is kept."""
    monkeypatch.setattr(Gaussian, "size_of", lambda self, sample: 1.0)
    monkeypatch.setattr(fitting, "LOST", 0.0)


def known() -> Gaussian:
    return Gaussian.fit(SAMPLES)


def prior(model: Gaussian) -> Array:
    return by_feature(model.scale, WIDTH)


def assert_alike(model: Gaussian, dense: Dense) -> None:
    for hour, features in zip(NEW.hours, NEW.features, strict=True):
        mean, variance = dense.predict(99, hour, features)
        assert features @ model.weights == pytest.approx(mean, rel=1e-6, abs=1e-8)
        novelty = model.novelty(features[None])[0]
        assert 1.0 + model.walk**2 * hour + novelty == pytest.approx(variance, rel=1e-7)


@pytest.mark.usefixtures("walks_alike")
def test_the_scales_are_the_likeliest():
    model = known()

    def cost(scale: Array, walk: float) -> float:
        dense = Dense.of(by_feature(scale, WIDTH), walk, SAMPLES)
        # Weak priors: all weights of a group together are 2.2 um/K, give or take a factor of e, and
        # the walk e squared.
        each = 2.2 / np.sqrt(WIDTH / len(scale))
        usual = 0.5 * np.log(np.outer(scale, dense.noise)) - np.log(each)
        return dense.cost() + 0.5 * float(np.sum(usual**2) + (np.log(walk) / 2.0) ** 2)

    best = cost(model.scale, model.walk)
    for group in np.eye(len(model.scale)):
        for scale, walk in ((1.2, 1.0), (1 / 1.2, 1.0), (1.0, 1.05), (1.0, 1 / 1.05)):
            assert cost(scale**group * model.scale, walk * model.walk) > best


def with_mean(sample: Sample, seed: int, *shares: float) -> Sample:
    """Return a run whose mean function says something that bears a share on each target."""
    steps = np.random.default_rng(seed).normal(0.0, 2.0, sample.targets.shape)
    mean = np.cumsum(steps, axis=0)
    return replace(sample, targets=sample.targets + np.array(shares) * mean, mean=mean)


@pytest.mark.usefixtures("walks_alike")
def test_a_mean_function_counts_as_far_as_runs_that_it_was_not_fitted_to_bear_it_out():
    runs = [with_mean(one, seed, 0.6, -0.4) for seed, one in enumerate(SAMPLES)]
    model = Gaussian.fit(runs)
    assert model.share == pytest.approx([0.6, 0.0], abs=0.1)
    assert Gaussian.fit(SAMPLES).share.tolist() == [0.0, 0.0]  # it says nothing

    def cost(share: float) -> float:
        left = [replace(one, targets=one.targets - [share, 0.0] * one.mean) for one in runs]
        return Dense.of(prior(model), model.walk, left).cost()

    best = cost(model.share[0])
    assert best < cost(model.share[0] + 0.02)
    assert best < cost(model.share[0] - 0.02)
    assert Gaussian.fit(runs, np.ones(2)).share.tolist() == [1.0, 1.0]


def test_a_run_that_wanders_teaches_less(monkeypatch):
    runs = [*SAMPLES, *FURTHER, drawn(5, WEIGHTS, walk=WALK, size=30.0)]

    def off(model: Gaussian) -> float:
        return float(np.sqrt(np.mean((NEW.features @ (model.weights - WEIGHTS)) ** 2)))

    careful = Gaussian.fit(runs)
    sizes = [careful.size_of(one) for one in runs]
    assert sizes[-1] > 2.0 * max(sizes[:-1])
    monkeypatch.setattr(Gaussian, "size_of", lambda self, sample: 1.0)
    assert off(careful) < 0.7 * off(Gaussian.fit(runs))


@pytest.mark.parametrize(("rows", "step_s"), [(150, 120.0), (60, 600.0), (20, 3600.0)])
def test_the_size_of_a_walk_does_not_depend_on_how_often_it_is_measured(rows, step_s):
    told = replace(known(), weights=WEIGHTS, spread=np.eye(2), walk=WALK, share=np.zeros(2))
    walks = [drawn(s, WEIGHTS, walk=WALK, rows=rows, step_s=step_s) for s in range(200)]
    assert np.mean([told.size_of(one) ** 2 for one in walks]) == pytest.approx(1.0, abs=0.05)


def test_an_update_sizes_a_walk_by_what_it_has_learnt_as_a_fit_does():
    model, after = known(), known().updated(FURTHER)
    inside = np.linalg.inv(model.covariance)
    total = inside @ model.weights
    for one in FURTHER:
        covariance = np.eye(len(one.hours)) + (model.walk * after.size_of(one)) ** 2 * (
            np.minimum.outer(one.hours, one.hours)
        )
        weighted = np.linalg.solve(covariance, one.features).T
        inside, total = inside + weighted @ one.features, total + weighted @ one.targets
    assert after.weights == pytest.approx(np.linalg.solve(inside, total), abs=1e-4)


@pytest.mark.usefixtures("walks_alike")
def test_an_update_needs_no_old_run():
    model = known()
    whole = model.updated(FURTHER)
    assert_alike(whole, Dense.of(prior(model), model.walk, [*SAMPLES, *FURTHER]))
    anew = Gaussian.fit([*SAMPLES, *FURTHER])  # at scales of its own, which are nearly the same
    assert whole.spread == pytest.approx(anew.spread, rel=0.3, abs=0.1)
    exact = [replace(one, targets=one.features @ model.weights) for one in FURTHER]
    for _ in range(20):
        model = model.updated(exact)
    assert (np.diag(model.spread) >= fitting.SMALLEST_NOISE**2).all()
    assert whole.rows == sum(len(one.hours) for one in (*SAMPLES, *FURTHER))


def test_directions_left_out_make_an_interval_wider_and_never_narrower():
    model = known()
    rows = directions(model, SAMPLES)
    assert 0 < len(rows) < WIDTH
    kept = np.diag(prior(model)) - rows.T @ rows
    assert np.linalg.eigvalsh(kept - model.covariance).min() > -1e-9 * model.scale.max()
    for one in SAMPLES:
        wide = np.einsum("ij,jk,ik->i", one.features, kept, one.features)
        usual = 1.0 + model.walk**2 * one.hours + model.novelty(one.features)
        assert np.mean(wide - model.novelty(one.features)) < 0.1 * np.mean(usual)


def installed(model: Gaussian) -> Installed:
    """Return the runtime's Gaussian with all directions."""
    return Installed(
        "start",
        [0.0] * INPUTS,
        [0.0, 0.0],
        [1.0, 1.0],
        0.0,
        list(LAGS_S),
        model.weights.T.tolist(),
        model.scale.tolist(),
        directions(model, SAMPLES).tolist(),
        model.walk**2,
        np.linalg.cholesky(model.spread).tolist(),
        2.35,
        0.9,
    )


def test_lags_of_an_even_rise_do_not_depend_on_the_steps():
    told = []
    for step_s in (3600.0, 900.0, 10.0):
        time_s = np.arange(0.0, 7200.1, step_s)
        works = installed(known())
        for row, time in enumerate(time_s.tolist()):
            works.step([time / 720.0, time / -360.0], step_s if row else 0.0)
        features = with_lags(time_s, time_s[:, None] * [1.0 / 720.0, -1.0 / 360.0])
        told.append([*features[-1], *works.added, works.variance])
    assert told[0] == pytest.approx(told[2], rel=1e-9)
    assert told[1] == pytest.approx(told[2], rel=1e-9)


def step(works: Installed, row: int) -> Array:
    elapsed = 3600.0 * (NEW.hours[row] - (NEW.hours[row - 1] if row else 0.0))
    works.step(NEW.features[row, :INPUTS].tolist(), float(elapsed))
    return np.array(works.added)


@pytest.mark.usefixtures("walks_alike")
def test_probing_is_regression_on_the_measured_rows_too():
    model = known()
    works, dense = installed(model), Dense.of(prior(model), model.walk, SAMPLES)
    works.step([0.0] * INPUTS, 0.0)
    for row, (hour, features) in enumerate(zip(NEW.hours, NEW.features, strict=True)):
        added = step(works, row)
        mean, variance = dense.predict(99, hour, features)
        assert added == pytest.approx(mean, rel=1e-6, abs=1e-8)
        assert works.variance == pytest.approx(variance, rel=1e-7)
        if row in (3, 4, 15, 16, 30):
            seen = added + [1.0, -0.7] * np.sqrt(np.diag(model.spread))
            works.take((seen - added).tolist())
            dense.measured(99, hour, features, seen)


@pytest.mark.usefixtures("walks_alike")
def test_a_bad_probe_changes_nothing_until_the_next_one_confirms_it():
    model = known()
    works, plain = installed(model), installed(model)
    spread = np.sqrt(np.diag(model.spread))
    far = 5.0 * 2.35 * np.sqrt(1.0 + works.variance) * spread
    for row in range(6):
        step(works, row)
        step(plain, row)
    works.take(far.tolist())
    assert step(works, 6) == pytest.approx(step(plain, 6), abs=0.0)
    assert works.variance == plain.variance
    for one in (works, plain):  # a good one after it: the bad one is forgotten
        one.take([0.0, 0.0])
        step(one, 7)
    works.take(far.tolist())
    assert step(works, 8) == pytest.approx(step(plain, 8), abs=0.0)
    works.take((-far).tolist())  # as far on the other side confirms nothing
    assert step(works, 9) == pytest.approx(step(plain, 9), abs=0.0)
    works.take((0.9 * -far).tolist())
    moved = step(works, 10) - step(plain, 10)
    assert moved == pytest.approx(-0.9 * far, rel=0.1)
    assert works.variance < plain.variance + 1.0


@pytest.mark.parametrize(("half_widths", "believed"), [(2.5, True), (3.5, False)])
def test_a_probe_is_believed_as_far_as_a_run_may_creep(half_widths, believed):
    works = installed(known())
    for row in range(6):
        before = step(works, row)
    half = works.deviations * np.sqrt(works.variance) * np.array(works.spread)
    works.take((half_widths * half).tolist())
    moved = np.abs(step(works, 6) - before)
    assert (moved > 0.5 * half).all() == believed


@pytest.mark.usefixtures("walks_alike")
def test_a_confirmed_leap_is_a_leap_of_the_walk():
    model = known()
    works, dense = installed(model), Dense.of(prior(model), model.walk, SAMPLES)
    spread = np.sqrt(np.diag(model.spread))
    far = np.array([40.0, -30.0]) * spread
    for row in range(5):
        added = step(works, row)
    works.take(far.tolist())
    added = step(works, 5)
    works.take(far.tolist())
    leap = 40.0**2
    dense.measured(99, NEW.hours[5], NEW.features[5], added + far, leap)
    for row in range(6, 12):
        mean, variance = dense.predict(99, NEW.hours[row], NEW.features[row], leap)
        assert step(works, row) == pytest.approx(mean, rel=1e-6)
        assert works.variance == pytest.approx(variance, rel=1e-6)


def test_the_measurements_before_the_last_eight_only_narrow_less():
    works, plain = installed(known()), installed(known())
    lengths = []
    for row in range(30):
        step(works, row)
        step(plain, row)
        works.take([0.0, 0.0])
        assert works.variance <= plain.variance
        lengths.append(len(works.state()))
    assert len(set(lengths[:8])) == 8
    assert set(lengths[8:]) == {lengths[7]}
    assert 1.0 <= works.variance < 0.8 * plain.variance


def test_culprits_are_the_inputs_that_bring_most_of_the_novelty():
    model, works = known(), installed(known())
    covariance = np.diag(prior(model)) - (rows := directions(model, SAMPLES)).T @ rows
    for row, features in enumerate(NEW.features):
        step(works, row)
        parts = (features * (covariance @ features)).reshape(-1, INPUTS).sum(axis=0)
        assert works.novelty == pytest.approx(parts.sum())
        named = works.culprits()
        assert named[0] == np.argmax(parts)
        assert parts[named].sum() >= 0.5 * parts.sum()
        assert parts[named[:-1]].sum() < 0.5 * parts.sum()


def test_an_average_predicts_the_mean_of_both_models_and_is_as_sure_as_the_first():
    shared = np.arange(WIDTH) % INPUTS == 0
    part = Gaussian.fit([replace(one, features=one.features[:, shared]) for one in SAMPLES])
    both = known().averaged(part, shared)
    expected = (NEW.features @ known().weights + NEW.features[:, shared] @ part.weights) / 2.0
    assert NEW.features @ both.weights == pytest.approx(expected)
    assert both.novelty(NEW.features) == pytest.approx(known().novelty(NEW.features))


@pytest.mark.parametrize(
    "damage",
    [
        lambda state: state[:-1],
        lambda state: [*state, 0.0],
        lambda state: [nan, *state[1:]],
        lambda state: [*state[:7], inf, *state[8:]],
        lambda state: [*state[:6], 1.0, *state[7:]],
        lambda state: [*state[:7], 9.0, *state[8:]],
        lambda state: [*state[:7], -1.0, *state[8:]],
        lambda state: [*state[:7], "one", *state[8:]],
        lambda state: [*state[:3], None, *state[4:]],
    ],
)
def test_a_damaged_state_is_refused(damage):
    works = installed(known())
    step(works, 0)
    works.take([0.1, 0.1])
    step(works, 1)
    with pytest.raises(ValueError, match="state"):
        works.restore(damage(works.state()))


def read(table: dict[str, Any]) -> Installed:
    fields = Fields(json.loads(json.dumps(table)), "f.json", "gaussian")
    return Installed.from_fields(fields, INPUTS, 2)


@pytest.mark.parametrize(
    ("change", "told"),
    [
        ({"reference": "end"}, "gaussian.reference"),
        ({"reference": "fixed"}, "gaussian.usual"),
        ({"usual": [20.0, 20.0]}, "not a known field"),
        ({"noise": [[1.0, 0.0], [2.0, 0.0]]}, "gaussian.noise.1.1: 0 is not allowed: above 0"),
        ({"weights": [[0.0] * 2] * 3}, "gaussian.weights"),
        ({"lags_s": [600.0]}, "gaussian.weights.0"),
        ({"seen": [[1.0]]}, "gaussian.seen.0"),
        ({"scale": [-1.0]}, "gaussian.scale.0"),
        ({"walk_per_h": -1.0}, "gaussian.walk_per_h"),
        ({"coverage": 1.0}, "gaussian.coverage"),
        ({"rows": None}, "gaussian.rows"),
    ],
)
def test_a_wrong_field_is_refused_in_one_line(change, told):
    read(knows_nothing(2))
    assert told in refusal(read, knows_nothing(2) | change)
