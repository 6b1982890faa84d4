"""Regression in which the run is the unit."""

import numpy as np
import pytest

from studies.fit.by_run import Block, NormalEquations


def blocks_of(count: int, seed: int = 0, wander: float = 0.0, rows: int = 60) -> list[Block]:
    random = np.random.default_rng(seed)
    blocks = []
    for _ in range(count):
        x = np.cumsum(random.standard_normal((rows, 2)), axis=0)
        hours = np.arange(rows) / 12.0
        noise = np.cumsum(random.standard_normal(rows)) * wander + random.standard_normal(rows)
        blocks.append(Block(hours, x, (x @ [2.0, -1.0] + noise)[:, None]))
    return blocks


def test_without_walk_and_trust_it_is_plain_ridge():
    blocks = blocks_of(3)
    found = NormalEquations(blocks, 0.0).solve(0, 1e-3, robust=False)
    x = np.concatenate([block.features for block in blocks])
    y = np.concatenate([block.targets[:, 0] for block in blocks])
    size = np.sqrt(np.mean(x**2, axis=0))
    scaled = x / size
    b = np.linalg.solve(scaled.T @ scaled / len(x) + 1e-3 * np.eye(2), scaled.T @ y / len(x)) / size
    assert found.coefficients == pytest.approx(b)


def test_left_out_errors_are_those_of_fits_without_the_run():
    blocks = blocks_of(4)
    found = NormalEquations(blocks, 0.5).solve(0, 1e-6, robust=False)
    for out in range(4):
        rest = [block for number, block in enumerate(blocks) if number != out]
        b = NormalEquations(rest, 0.5).solve(0, 1e-6, robust=False).coefficients
        missed = blocks[out].targets[:, 0] - blocks[out].features @ b
        assert found.left_out_rms[out] == pytest.approx(np.sqrt(np.mean(missed**2)), rel=1e-3)


def test_one_run_has_nothing_left_out():
    found = NormalEquations(blocks_of(1), 0.0).solve(0, 1e-6)
    assert np.isnan(found.left_out_rms).all()
    assert found.coefficients == pytest.approx([2.0, -1.0], abs=0.2)
