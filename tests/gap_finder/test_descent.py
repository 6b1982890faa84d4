"""A descent arrives: where all is linear at once, along a narrow curved valley before long."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import least_squares

from gap_finder.descent import ITERATIONS, SHARES, Descent, Point
from gap_finder.likelihood import Quadratic

ONE = np.ones((1, 1))
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


def point(residual: Callable[[np.ndarray], np.ndarray], x: np.ndarray) -> Point:
    """Return a point with the cost about it, and what to expect by its slopes."""
    jacobian, left = slopes(residual, x), residual(x)
    matrix, right, cost = jacobian.T @ jacobian, jacobian.T @ left, float(left @ left)
    expected = cost - float(right @ np.linalg.solve(matrix, right))
    return Point(x, (), Quadratic(matrix, right, cost, np.ones(1), 1.0), expected)


def arrived(residual: Callable[[np.ndarray], np.ndarray], x: np.ndarray) -> tuple[Point, int]:
    """Return where a descent ended, and how many steps it took."""
    descent, steps = Descent(point(residual, x)), 0
    while not descent.is_done:
        steps += 1
        about = descent.at.about
        diagonal = np.diag(np.diag(about.matrix))
        trials = [
            descent.at.x - np.linalg.solve(about.matrix + damping * diagonal, about.right)
            for damping in descent.dampings
        ]
        taken = descent.best_of(np.array([np.sum(residual(trial) ** 2) for trial in trials]))
        if taken is not None:
            descent.at = point(residual, trials[taken])
    return descent.at, steps


def test_it_does_not_creep_along_a_narrow_curved_valley():
    at, steps = arrived(motor, np.array([0.0, 0.0, 2.0]))
    assert at.cost == pytest.approx(2.0 * least_squares(motor, np.zeros(3)).cost, rel=1e-3)
    assert steps < ITERATIONS / 2


def test_where_all_is_linear_one_step_is_enough():
    jacobian = np.array([[1.0, 2.0], [0.0, 1e-3], [3.0, 1.0]])
    at, steps = arrived(lambda x: jacobian @ x - 1.0, np.zeros(2))
    assert at.x == pytest.approx(np.linalg.lstsq(jacobian, np.ones(3), rcond=None)[0])
    assert steps == 2  # the second finds nothing better


def test_it_ends_where_no_step_helps_and_takes_none_that_cannot_be_stepped():
    descent = Descent(Point(np.zeros(1), (), Quadratic(ONE, ONE[0], 1.0, ONE[0], 1.0), 0.0))
    tried = np.arange(float(len(SHARES)))[:, None]
    taken = descent.best_of(np.array([np.nan, 2.0, 0.4, 0.5]))
    assert taken == 2
    descent.at = replace(descent.at, x=tried[taken])
    dampings = []
    while not descent.is_done:
        dampings.append(descent.damping)
        assert descent.best_of(np.full(len(SHARES), np.nan)) is None
    assert dampings == sorted(dampings)
    assert descent.at.x == pytest.approx([2.0])
