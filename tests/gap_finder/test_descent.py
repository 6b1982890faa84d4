"""A descent arrives: where all is linear at once, along a narrow curved valley before long."""

from collections.abc import Callable

import numpy as np
import pytest
from scipy.optimize import least_squares

from gap_finder.descent import ITERATIONS, Descent

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


def squares(residual: np.ndarray) -> float:
    return float(residual @ residual)


def arrived(residual: Callable[[np.ndarray], np.ndarray], x: np.ndarray) -> tuple[Descent, int]:
    """Return a descent where it ended, and how many steps it tried."""
    descent, steps = Descent(x, squares(residual(x)), []), 0
    while not descent.is_done:
        jacobian = slopes(residual, descent.x)
        matrix, slope = jacobian.T @ jacobian, jacobian.T @ residual(descent.x)
        damped = matrix + descent.damping * np.diag(np.diag(matrix))
        moved = -np.linalg.solve(damped, slope)
        promised = descent.cost - squares(residual(descent.x) + jacobian @ moved)
        if descent.promised(promised):
            steps += 1
            x = descent.x + moved
            descent.take(x, squares(residual(x)), [], promised)
    return descent, steps


def test_it_does_not_creep_along_a_narrow_curved_valley():
    descent, steps = arrived(motor, np.array([0.0, 0.0, 2.0]))
    assert descent.cost == pytest.approx(2.0 * least_squares(motor, np.zeros(3)).cost, rel=1e-3)
    assert steps < ITERATIONS


def test_where_all_is_linear_two_steps_are_enough():
    jacobian = np.array([[1.0, 2.0], [0.0, 1e-3], [3.0, 1.0]])
    descent, steps = arrived(lambda x: jacobian @ x - 1.0, np.zeros(2))
    found = np.linalg.lstsq(jacobian, np.ones(3), rcond=None)[0]
    assert descent.cost == pytest.approx(squares(jacobian @ found - 1.0), rel=1e-3)
    assert steps <= 2  # the first is damped a little


def test_it_damps_ever_more_until_a_step_helps_or_hardly_changes_anything():
    descent, dampings = Descent(np.zeros(1), 1.0, []), []
    for cost, promised in ((np.inf, 0.5), (5.0, 1e-9), (np.inf, 1e-9)):
        assert descent.promised(promised)
        descent.take(np.array([3.0]), cost, [], promised)
        dampings.append(descent.damping)
    assert dampings == pytest.approx([0.02, 0.08, 0.64])
    descent.take(np.array([2.0]), 0.4, [], 0.6)
    assert (descent.x, descent.cost) == (2.0, 0.4)
    descent.take(np.array([2.1]), 0.4 + 1e-5, [], 0.1)
    assert descent.is_done
    assert (descent.x, descent.cost) == (2.0, 0.4)
