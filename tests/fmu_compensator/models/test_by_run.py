"""Regression and intervals in which the run is the unit."""

from __future__ import annotations

import numpy as np
import pytest

from fmu_compensator.fit.by_run import Block, NormalEquations
from fmu_compensator.fit.intervals import Residuals, conformal


def blocks_of(count: int, seed: int = 0, wander: float = 0.0, rows: int = 60) -> list[Block]:
    random = np.random.default_rng(seed)
    blocks = []
    for _ in range(count):
        x = np.cumsum(random.standard_normal((rows, 2)), axis=0)
        hours = np.arange(rows) / 12.0
        noise = np.cumsum(random.standard_normal(rows)) * wander + random.standard_normal(rows)
        blocks.append(Block(hours, x, (x @ [2.0, -1.0] + noise)[:, None]))
    return blocks


def test_without_walk_and_trust_it_is_plain_ridge() -> None:
    blocks = blocks_of(3)
    found = NormalEquations(blocks, 0.0).solve(0, 1e-3, robust=False)
    x = np.concatenate([block.features for block in blocks])
    y = np.concatenate([block.targets[:, 0] for block in blocks])
    size = np.sqrt(np.mean(x**2, axis=0))
    scaled = x / size
    b = np.linalg.solve(scaled.T @ scaled / len(x) + 1e-3 * np.eye(2), scaled.T @ y / len(x)) / size
    assert found.coefficients == pytest.approx(b)


def test_left_out_errors_are_those_of_fits_without_the_run() -> None:
    blocks = blocks_of(4)
    found = NormalEquations(blocks, 0.5).solve(0, 1e-6, robust=False)
    for out in range(4):
        rest = [block for number, block in enumerate(blocks) if number != out]
        b = NormalEquations(rest, 0.5).solve(0, 1e-6, robust=False).coefficients
        missed = blocks[out].targets[:, 0] - blocks[out].features @ b
        assert found.left_out_rms[out] == pytest.approx(np.sqrt(np.mean(missed**2)), rel=1e-3)


def test_a_walk_in_the_noise_is_whitened() -> None:
    errors: dict[float, list[float]] = {0.0: [], 5.0: []}
    for seed in range(20):
        blocks = blocks_of(3, seed, wander=1.5)
        for walk, found in errors.items():
            b = NormalEquations(blocks, walk).solve(0, 1e-9, robust=False).coefficients
            found.append(float(np.linalg.norm(b - [2.0, -1.0])))
    assert np.mean(errors[5.0]) < 0.7 * np.mean(errors[0.0])


def test_a_noisy_first_sample_is_whitened() -> None:
    errors: dict[bool, list[float]] = {False: [], True: []}
    for seed in range(20):
        blocks = []
        for block in blocks_of(3, seed):
            y = block.targets + 3.0 * np.random.default_rng(seed).standard_normal()
            blocks.append(Block(block.hours, block.features, y))
        for referenced, found in errors.items():
            b = NormalEquations(blocks, 0.0, referenced=referenced).solve(0, 1e-9, robust=False)
            found.append(float(np.linalg.norm(b.coefficients - [2.0, -1.0])))
    assert np.mean(errors[True]) < 0.7 * np.mean(errors[False])


def test_an_odd_run_loses_trust() -> None:
    blocks = blocks_of(6)
    odd = Block(blocks[5].hours, blocks[5].features, -blocks[5].targets)
    found = NormalEquations([*blocks[:5], odd], 0.0).solve(0, 1e-6)
    assert found.trust[5] < 0.05 * np.median(found.trust)
    assert found.coefficients == pytest.approx([2.0, -1.0], abs=0.1)


def test_one_run_has_nothing_left_out() -> None:
    found = NormalEquations(blocks_of(1), 0.0).solve(0, 1e-6)
    assert np.isnan(found.left_out_rms).all()
    assert found.coefficients == pytest.approx([2.0, -1.0], abs=0.2)


def wandering(count: int, seed: int, size: float = 1.0) -> list[Residuals]:
    random = np.random.default_rng(seed)
    hours = np.arange(1, 61) / 12.0
    return [
        Residuals(hours, np.cumsum(size * random.standard_normal((60, 2)), axis=0))
        for _ in range(count)
    ]


def test_the_interval_holds_what_it_promises_on_new_runs() -> None:
    held = []
    for seed in range(10):
        interval = conformal(wandering(20, seed))
        held += [interval.within(one) for one in wandering(50, 100 + seed)]
    # 20 runs learn the quantile at 0.945; the promise is at least 0.9 on the whole.
    assert 0.9 <= np.mean(held) <= 0.97


def test_samples_of_a_dense_run_do_not_outweigh_the_others() -> None:
    quiet, loud = wandering(9, 0), wandering(1, 1, size=20.0)[0]
    dense = Residuals(np.repeat(loud.hours, 50), np.repeat(loud.values, 50, axis=0))
    assert conformal([*quiet, dense]).scale == pytest.approx(conformal([*quiet, loud]).scale)


def test_with_few_runs_the_worst_run_counts() -> None:
    runs = wandering(3, 2)
    interval = conformal(runs)
    held = np.array([interval.within(run) for run in runs])
    # 60 samples a run: 0.9 is 54 of them.
    assert held.min(axis=0) == pytest.approx([0.9, 0.9], abs=1e-9)
    scaled = [np.abs(run.values) / interval.half_width(run) for run in runs]
    assert sum(np.isclose(one, 1.0).any(axis=0).all() for one in scaled) >= 1


def test_new_inputs_make_it_wider_and_unlike_runs_count_apart() -> None:
    random = np.random.default_rng(6)
    hours = np.arange(1, 61) / 12.0

    def run(novelty: float, *, unlike: bool = False) -> Residuals:
        size = np.sqrt(1.0 + novelty)
        values = size * random.standard_normal((60, 2))
        return Residuals(hours, values, np.full(60, novelty), unlike)

    like = [run(0.2) for _ in range(12)]
    interval = conformal([*like, *(run(9.0, unlike=True) for _ in range(12))])
    narrow, wide = (interval.half_width(run(novelty)).mean() for novelty in (0.0, 15.0))
    assert wide == pytest.approx(4.0 * narrow) if interval.per_novelty == 1.0 else wide > narrow
    # Errors that do not grow with novelty: it widens all the same, by no less than theory says.
    assert conformal([*like, *(run(0.0) for _ in range(12))]).per_novelty >= 1.0
    # A few unlike runs with large errors are not drowned by many like ones.
    loud = [
        Residuals(hours, 5.0 * random.standard_normal((60, 2)), np.zeros(60), True)
        for _ in range(3)
    ]
    assert (conformal([*like, *loud]).scale > 2.5 * conformal(like).scale).all()


def test_errors_that_do_not_grow_get_an_interval_that_does_not() -> None:
    random = np.random.default_rng(4)
    hours = np.arange(1, 61) / 12.0
    steady = [Residuals(hours, random.standard_normal((60, 2))) for _ in range(12)]
    assert conformal(steady).power == 0.0
    assert conformal(wandering(12, 4)).power == 0.5


def test_the_width_grows_with_time_up_to_the_longest_run() -> None:
    interval = conformal(wandering(5, 3))
    hours = np.array([0.0, 1.0, 5.0, 50.0])
    width = interval.half_width(Residuals(hours, np.zeros((4, 2))))
    assert (np.diff(width[:3], axis=0) > 0).all()
    assert width[3] == pytest.approx(width[2])
    with pytest.raises(ValueError, match="no run"):
        conformal([])
