"""The hybrid: weights by vector angle cosine, its least-squares twin, adaptive weights."""

from itertools import product
from typing import Any

import numpy as np
import pytest

from measurement.errors import BadInput
from studies.fit.vac import VectorAngleCosine, _Rows
from tests.fmu_compensator.models.made import lag, run_of, steps, task_of
from tests.refusing import refusal


def made(seed: int = 0, rows: int = 200) -> tuple[Any, Any]:
    random = np.random.default_rng(seed)
    y = np.cumsum(random.standard_normal((rows, 1)), axis=0)
    parts = np.stack([y + random.standard_normal(y.shape) * size for size in (0.5, 2.0, 8.0)], 2)
    return run_of(random.standard_normal((rows, 1)), y, speed=np.full(rows, 1000.0)), parts


def cosine(a: Any, b: Any) -> float:
    return float(a @ b / np.linalg.norm(a) / np.linalg.norm(b))


def test_no_weights_on_a_grid_have_a_larger_cosine():
    run, parts = made()
    rows = _Rows([run], [parts])
    weights, prior = rows.combined("cosine")
    w = weights["steady"][0]
    assert w.sum() == pytest.approx(1.0)
    assert (w >= 0).all()
    assert prior.size == 0
    root = np.sqrt(run.weights)
    y = root * run.targets[:, 0]
    found = cosine(root * (parts[:, 0] @ w), y)
    grid = np.linspace(0, 1, 41)
    best = max(
        cosine(root * (parts[:, 0] @ np.array([a, b, 1 - a - b])), y)
        for a, b in product(grid, grid)
        if a + b <= 1
    )
    assert found >= best - 1e-12
    assert rows.cosines(weights["steady"])[0] == pytest.approx(found, abs=1e-5)


def test_the_cosine_does_not_see_a_common_factor_and_least_squares_does():
    run, parts = made()
    wrong = _Rows([run], [0.5 * parts])
    by_cosine, _ = wrong.combined("cosine")
    by_squares, _ = wrong.combined("least_squares")
    right, _ = _Rows([run], [parts]).combined("cosine")
    assert by_cosine["steady"] == pytest.approx(right["steady"])
    assert by_squares["steady"].sum() == pytest.approx(2.0, rel=0.05)


def two_condition_task(seeds: range) -> Any:
    """Drift follows T1 while turning; while standing T1 sees the spindle only half.

    So one weight for all times is a compromise, and one per condition is right.
    """
    runs = []
    for seed in seeds:
        speed = steps(seed, rows=400, hold=50)
        temperature = lag(speed / 1000.0, 900.0)
        slow = lag(speed / 1000.0, 5000.0)
        drift = np.where(speed > 0, temperature, 2.0 * temperature)
        runs.append(
            run_of(
                np.column_stack([temperature, slow]), drift[:, None], speed=speed, name=f"r{seed}"
            )
        )
    return task_of(runs)


def test_weights_adapt_to_the_condition():
    task = two_condition_task(range(4))
    unseen = two_condition_task(range(8, 10)).runs
    errors = {}
    for combination in ("least_squares", "adaptive"):
        fitted = VectorAngleCosine.fit(task, models=["mlr", "ne"], combination=combination)
        missed = np.concatenate([run.targets - fitted.predict(run) for run in unseen])
        errors[combination] = float(np.sqrt(np.mean(missed**2)))
    assert errors["adaptive"] < 0.9 * errors["least_squares"]


def test_measurements_move_the_weights_to_the_model_that_is_right():
    task = two_condition_task(range(4))
    members = VectorAngleCosine.fit(task, models=["mlr", "ne"]).models
    half = dict.fromkeys(("stopped", "changing", "steady"), np.full((1, 2), 0.5))
    hybrid = VectorAngleCosine(["mlr", "ne"], members, half, np.ones((1, 2)), {})
    run = two_condition_task(range(8, 9)).runs[0]
    truth = members[1].predict(run) + np.linspace(0.0, 0.05, len(run.time_s))[:, None]
    plain, told = hybrid.predict(run), hybrid.predict(run, truth)
    late = slice(200, None)
    assert np.abs(told - truth)[late].mean() < 0.2 * np.abs(plain - truth)[late].mean()
    assert hybrid.uses_measured


def test_constituents_have_options_of_their_own():
    task = two_condition_task(range(2))
    options = {"models": "mlr,ne", "parts": {"ne": {"tau_s": 900.0}, "mlr": {"subset": False}}}
    hybrid = VectorAngleCosine.fit(task, **options)
    exponential = hybrid.models[list(hybrid.kinds).index("ne")]
    assert set(exponential.report()["tau_s"]) == {900.0}
    assert set(hybrid.report()["weights"]) == {"steady"}
    with pytest.raises(BadInput, match=r"parts.fem: is not allowed: options of mlr, ne"):
        VectorAngleCosine.fit(task, models="mlr,ne", parts={"fem": {"modes": 8}})
    with pytest.raises(BadInput, match="parts: 'ne' is not allowed: options by model"):
        VectorAngleCosine.fit(task, models="mlr,ne", parts="ne")
    with pytest.raises(BadInput, match="ne: speed: is not a known option"):
        VectorAngleCosine.fit(task, models="mlr,ne", parts={"ne": {"speed": 1.0}})


@pytest.mark.parametrize(
    ("options", "told"),
    [
        ({"models": ["mlr"]}, "2 to 10 different models"),
        ({"models": ["mlr", "mlr"]}, "2 to 10 different models"),
        ({"models": ["mlr", "vac"]}, "'vac' is not allowed"),
        ({"combination": "best"}, "'best' is not allowed: cosine, least_squares, adaptive"),
    ],
)
def test_wrong_options_are_refused(options, told):
    assert told in refusal(VectorAngleCosine.fit, two_condition_task(range(1)), **options)
