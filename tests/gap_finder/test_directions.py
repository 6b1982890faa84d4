"""Fewer columns must say the same of everything that is measured."""

import numpy as np

from gap_finder.directions import NEGLIGIBLE_SQUARES, fewer


def test_fewer_columns_are_the_same_prior():
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
    assert 0.0 < np.trace(lost) <= NEGLIGIBLE_SQUARES
    assert np.linalg.eigvalsh(lost).min() > -1e-9


def test_what_moves_nothing_is_gone():
    (left,) = fewer([np.zeros((5, 3))])
    assert left.shape == (5, 0)
