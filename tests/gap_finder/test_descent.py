"""A descent arrives: where all is linear at once, along a narrow curved valley before long."""

from collections.abc import Callable

import numpy as np
import pytest
from scipy.optimize import least_squares

from gap_finder.descent import ITERATIONS, SHARES, Descent

SPEEDS = np.array([0.25, 0.5, 0.85, 0.9, 1.0])


def motor(x: np.ndarray) -> np.ndarray:
    """Return residuals of a motor's heat: iron loss, its eddy share, and a loss known by its log.

    True are 0.7, 0.75 and -1.5, and the heat is known fifty times as well as the prior.
    """

    def heat(x: np.ndarray) -> np.ndarray:
        power, eddy, loss = 2.0 * x[0], 0.6 + 0.25 * x[1], np.exp(0.46 * x[2])
        return power * ((1.0 - eddy) * SPEEDS + eddy * SPEEDS**2) + loss * SPEEDS

    return np.append(50.0 * (heat(x) - heat(np.array([0.7, 0.75, -1.5]))), x)


def slopes(residual: Callable[[np.ndarray], np.ndarray], x: np.ndarray) -> np.ndarray:
    steps = 1e-6 * np.eye(len(x))
    return np.array([(residual(x + step) - residual(x)) / 1e-6 for step in steps]).T


def arrived(residual: Callable[[np.ndarray], np.ndarray], x: np.ndarray) -> tuple[Descent, int]:
    """Return a descent where it ended, and how many steps it took."""
    descent, steps = Descent(x, float(np.sum(residual(x) ** 2)), []), 0
    while not descent.is_done:
        steps += 1
        jacobian = slopes(residual, descent.x)
        matrix, slope = jacobian.T @ jacobian, jacobian.T @ residual(descent.x)
        diagonal = np.diag(np.diag(matrix))
        trials = np.array(
            [
                descent.x - np.linalg.solve(matrix + damping * diagonal, slope)
                for damping in descent.dampings
            ]
        )
        descent.take(trials, np.array([np.sum(residual(trial) ** 2) for trial in trials]))
    return descent, steps


def test_it_does_not_creep_along_a_narrow_curved_valley():
    descent, steps = arrived(motor, np.array([0.0, 0.0, 2.0]))
    assert descent.cost == pytest.approx(2.0 * least_squares(motor, np.zeros(3)).cost, rel=1e-3)
    assert steps < ITERATIONS / 2


def test_where_all_is_linear_one_step_is_enough():
    jacobian = np.array([[1.0, 2.0], [0.0, 1e-3], [3.0, 1.0]])
    descent, steps = arrived(lambda x: jacobian @ x - 1.0, np.zeros(2))
    assert descent.x == pytest.approx(np.linalg.lstsq(jacobian, np.ones(3), rcond=None)[0])
    assert steps == 2  # the second finds nothing better


def test_it_ends_where_no_step_helps_and_takes_none_that_cannot_be_stepped():
    descent = Descent(np.zeros(1), 1.0, [])
    tried = np.arange(float(len(SHARES)))[:, None]
    assert descent.take(tried, np.array([np.nan, 2.0, 0.4, 0.5])) == 2
    dampings = []
    while not descent.is_done:
        dampings.append(descent.damping)
        assert descent.take(tried, np.full(len(SHARES), np.nan)) is None
    assert dampings == sorted(dampings)
    assert descent.x == pytest.approx([2.0])
