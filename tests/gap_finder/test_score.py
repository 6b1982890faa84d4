"""The score against a dense least-squares problem that eliminates nothing."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from scipy.optimize import minimize

from gap_finder.design import RunDesign
from gap_finder.score import _Folds

RUNS, CHANNELS, MOVED, OTHER, OWN = 4, 3, 2, 3, 2


class _Linear(_Folds):
    """Folds of a machine whose every answer is linear."""

    def _simulated(self, points: np.ndarray) -> list[np.ndarray]:
        away = points - self._start
        return [one.residual + away @ one.shared.T for one in self._designs]


def _designs() -> list[RunDesign]:
    generator = np.random.default_rng(3)
    return [
        RunDesign(
            generator.normal(0.0, 2.0, rows * CHANNELS),
            generator.normal(size=(rows * CHANNELS, MOVED + OTHER)),
            generator.normal(size=(rows * CHANNELS, OWN)),
            np.ones(rows * CHANNELS),
        )
        for rows in (20, 25, 30, 22)
    ]


def _side_by_side(designs: list[RunDesign], columns: list[np.ndarray], x: np.ndarray) -> np.ndarray:
    """Return unknowns with their priors: those of all runs, then those of each run."""
    shared = columns[0].shape[1]
    rows, right = [], []
    for place, (one, its) in enumerate(zip(designs, columns, strict=True)):
        block = np.zeros((len(one.residual), shared + OWN * len(designs)))
        block[:, :shared] = its
        block[:, shared + OWN * place : shared + OWN * (place + 1)] = one.nuisance
        rows.append(block)
        right.append(-one.residual)
    unknown = rows[0].shape[1]
    rows.append(np.eye(unknown))
    right.append(np.concatenate([-np.pad(x, (0, unknown - len(x)))]))
    return np.asarray(np.linalg.lstsq(np.vstack(rows), np.concatenate(right), rcond=None)[0])


def _dense(designs: list[RunDesign], x: np.ndarray, out: int) -> float:
    """Return what is left of one run, every unknown of every other run side by side."""
    shared = designs[0].shared.shape[1]
    others = [one for i, one in enumerate(designs) if i != out]
    found = _side_by_side(others, [one.shared for one in others], x)
    left = designs[out].residual + designs[out].shared @ found[:shared]
    own = np.vstack([designs[out].nuisance, np.eye(OWN)])
    padded = np.concatenate([left, np.zeros(OWN)])
    best = np.linalg.lstsq(own, -padded, rcond=None)[0]
    return float(np.sum((padded + own @ best) ** 2))


class _Curved(_Linear):
    """Folds of a machine whose first two answers grow with each other's number."""

    def _simulated(self, points: np.ndarray) -> list[np.ndarray]:
        away = points - self._start
        bend = 0.4 * np.prod(away[:, :2], axis=1)[:, None]
        straight = zip(super()._simulated(points), self._designs, strict=True)
        return [shown + bend * one.shared[:, :2].sum(axis=1) for shown, one in straight]


def _folds(designs: list[RunDesign], x: np.ndarray, kind: type[_Linear] = _Linear) -> _Linear:
    free = np.full(MOVED, 1e9)
    moved: Any = SimpleNamespace(low=-free, high=free)
    observed: Any = [SimpleNamespace(channels=("a", "b", "c"))] * RUNS
    return kind(None, observed, moved, x, designs)  # type: ignore[arg-type]


def test_a_run_is_predicted_from_the_others_alone():
    designs, x = _designs(), np.array([0.4, -0.3])
    left = _folds(designs, x).left()
    assert left.shape == (RUNS, CHANNELS)
    for k in range(RUNS):
        assert left[k].sum() == pytest.approx(_dense(designs, x, k), rel=1e-9)


def test_each_fold_ends_where_its_own_runs_are_met_best():
    designs, x = _designs(), np.array([0.4, -0.3])
    folds = _folds(designs, x, _Curved)
    left = folds.left().sum(axis=1)
    for k in range(RUNS):
        without = np.array([k])

        def cost(point: np.ndarray, without: np.ndarray = without) -> float:
            shown = folds._simulated(point[None])
            return float(folds._costs(point[None], shown, without)[0])

        best = minimize(cost, folds._start).x[None]
        own = folds._simulated(best)[k][0]
        there = float(own @ designs[k].cleaned(own[:, None])[:, 0])
        assert left[k] == pytest.approx(there, rel=0.02)


def test_what_calibration_does_not_move_lies_where_all_runs_have_it():
    designs, x = _designs(), np.array([0.4, -0.3])
    columns = [one.shared[:, MOVED:] for one in designs]
    found = _side_by_side(designs, columns, np.zeros(0))[:OTHER]
    assert _folds(designs, x).other_position() == pytest.approx(found, rel=1e-9)
