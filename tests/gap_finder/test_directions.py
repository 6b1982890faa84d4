"""Fewer columns must say the same of everything that is measured."""

from __future__ import annotations

import numpy as np

from gap_finder.directions import LOST, fewer


def test_fewer_columns_are_the_same_prior() -> None:
    generator = np.random.default_rng(1)
    # Forty unknowns of which six mixtures move anything, and all move a hair.
    mixed = generator.normal(size=(6, 40))
    runs = [
        generator.normal(size=(n, 6)) @ mixed + 1e-4 * generator.normal(size=(n, 40))
        for n in (50, 80)
    ]
    few = fewer(runs)
    assert [part.shape for part in few] == [(50, 6), (80, 6)]
    whole, short = (np.vstack(part) for part in (runs, few))
    lost = whole @ whole.T - short @ short.T
    assert 0.0 < np.trace(lost) <= LOST
    assert np.linalg.eigvalsh(lost).min() > -1e-9


def test_a_prediction_of_one_run_from_another_stays() -> None:
    generator = np.random.default_rng(2)
    runs = [generator.normal(size=(n, 8)) @ generator.normal(size=(8, 60)) for n in (40, 30)]
    shown = generator.normal(size=40)
    told = []
    for first, second in (runs, fewer(runs)):
        matrix = first.T @ first + np.eye(first.shape[1])
        told.append(second @ np.linalg.solve(matrix, first.T @ shown))
    np.testing.assert_allclose(told[1], told[0], atol=0.01 * np.abs(told[0]).max())


def test_what_moves_nothing_is_gone() -> None:
    (left,) = fewer([np.zeros((5, 3))])
    assert left.shape == (5, 0)
