"""The likelihood against one that is minimised by brute force over everything at once."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from scipy.optimize import minimize

from gap_finder.likelihood import Likelihood, in_units
from gap_finder.linearise import Linearisation

ROWS, CHANNELS = 30, 2


def run(generator: np.random.Generator, errs_by: tuple[float, float]) -> Any:
    """Return one run's residual, its own columns, columns of errors and of one parameter."""
    noise = generator.normal(size=(ROWS, CHANNELS)) * errs_by
    columns = [generator.normal(size=(ROWS * CHANNELS, count)) for count in (3, CHANNELS, 1)]
    return noise.reshape(-1), *columns


@pytest.fixture
def runs() -> list[Any]:
    generator = np.random.default_rng(3)
    return [run(generator, (0.4, 5.0)) for _ in range(3)]


def likelihood(runs: list[Any]) -> Likelihood:
    """Return the likelihood of runs in which every row is an independent value."""
    observed: Any = SimpleNamespace(weights=np.ones((ROWS, CHANNELS)), tolerance=np.ones(CHANNELS))
    return Likelihood(
        [observed] * len(runs), [own for _, own, _, _ in runs], [e for *_, e, _ in runs]
    )


def linear(runs: list[Any], x: float = 0.0) -> list[Linearisation]:
    settled = np.zeros((ROWS * CHANNELS, 0)), np.zeros((1, ROWS * CHANNELS, 0))
    return [
        Linearisation(residual + x * slope[:, 0], slope, *settled) for residual, _, _, slope in runs
    ]


def brute_force(runs: list[Any]) -> float:
    """Return the least -2 log likelihood over units, errors and each run's own unknowns."""

    def cost(unknown: np.ndarray) -> float:
        logs, shared, own = np.split(unknown, [CHANNELS, 2 * CHANNELS])
        units = np.exp(np.maximum(logs, 0.0))
        total = float(unknown[CHANNELS:] @ unknown[CHANNELS:])
        for (residual, columns, errors, _), at in zip(runs, np.split(own, len(runs)), strict=True):
            left = (residual + columns @ at + errors @ shared).reshape(-1, CHANNELS)
            total += float(np.sum(left**2 / units)) + ROWS * float(np.sum(np.log(units)))
        return total

    start = np.concatenate([np.ones(CHANNELS), np.zeros(CHANNELS + 3 * len(runs))])
    return float(minimize(cost, start, method="BFGS", options={"gtol": 1e-7}).fun)


def test_it_is_the_least_over_units_errors_and_own_unknowns(runs, monkeypatch):
    monkeypatch.setattr("gap_finder.likelihood.ROUNDS", 30)
    monkeypatch.setattr("gap_finder.likelihood.robust_weights", np.ones_like)
    about = likelihood(runs).about(linear(runs))
    assert about.cost == pytest.approx(brute_force(runs), rel=1e-6)
    assert about.units[0] == 1.0  # within tolerance
    assert about.units[1] == pytest.approx(25.0, rel=0.3)


def test_a_few_rounds_are_enough(runs, monkeypatch):
    cost = likelihood(runs).about(linear(runs)).cost
    monkeypatch.setattr("gap_finder.likelihood.ROUNDS", 30)
    assert cost == pytest.approx(likelihood(runs).about(linear(runs)).cost, abs=0.01)


def test_its_slope_is_that_of_its_cost(runs, monkeypatch):
    monkeypatch.setattr("gap_finder.likelihood.ROUNDS", 30)
    monkeypatch.setattr("gap_finder.likelihood.robust_weights", np.ones_like)
    found = likelihood(runs)
    step = 1e-4
    costs = [found.about(linear(runs, x)).cost for x in (-step, step)]
    slope = (costs[1] - costs[0]) / (2.0 * step)
    assert 2.0 * found.about(linear(runs)).right[0] == pytest.approx(slope, rel=1e-5)


def test_a_channel_that_nothing_follows_counts_for_nothing(runs, monkeypatch):
    """The parameter is known from the other one, as if this one did not depend on it."""
    monkeypatch.setattr("gap_finder.likelihood.robust_weights", np.ones_like)
    wild, absent = np.array([1.0, 1e6]), np.array([1.0, 0.0])

    def known(by_residual: np.ndarray, by_slope: np.ndarray) -> float:
        scaled = [
            (
                np.tile(by_residual, ROWS) * residual,
                own,
                errors,
                np.tile(by_slope, ROWS)[:, None] * slope,
            )
            for residual, own, errors, slope in runs
        ]
        return float(likelihood(scaled).about(linear(scaled)).matrix[0, 0])

    assert known(wild, np.ones(2)) == pytest.approx(known(wild, absent), rel=1e-6)


def test_weights_in_units_are_those_of_each_channel():
    weights = in_units(np.ones(4), np.array([1.0, 4.0]))
    np.testing.assert_allclose(weights, [1.0, 0.5, 1.0, 0.5])
