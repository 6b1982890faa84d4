"""Two effects at once: what the screening proposes, and what becomes of it."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from gap_finder.calibrate import calibrate, quiet
from gap_finder.candidates import MOST, Candidate, with_effect
from gap_finder.design import RunDesign, RunSensitivities, all_sensitivities
from gap_finder.effect_rounds import _both, _round, select_effects
from gap_finder.observations import observe
from gap_finder.pairs import ProposedPair, _left_by, screened_pairs
from gap_finder.refit import CandidateFit, score_fit
from gap_finder.screen import NormalMatrices, ResidualSets, Screen
from gap_finder.search import Search
from plant_model.effects import catalogue
from plant_model.machine import Machine
from tests.gap_finder.conftest import runs_of

RUNS, TIMES, CHANNELS = 4, 120, 3
SIZE = TIMES * CHANNELS
NAMES = ("windage", "cutting_heat", "radiation", "copper_loss")

KNOWN = ("windage", "centrifugal_shift", "friction_speed_exponent")
ASKED = Search([name for name in catalogue() if name not in KNOWN])


def _smooth(generator: np.random.Generator, *shape: int) -> np.ndarray[Any, np.dtype[np.float64]]:
    steps = generator.standard_normal((*shape, TIMES, CHANNELS))
    return np.asarray(np.cumsum(steps, axis=-2).reshape(*shape, SIZE) / 4.0)


def _case(hidden: tuple[str, ...]) -> tuple[Any, list[Candidate], dict[str, int]]:
    """Return a baseline and ranked candidates, the third of which is like two others together."""
    generator = np.random.default_rng(3)
    own = _smooth(generator, len(NAMES), RUNS)
    own[2] = 0.6 * (own[0] + own[1]) + 0.35 * own[2]
    tried = [Candidate(name, {}, tuple(own[i])) for i, name in enumerate(NAMES)]
    designs = []
    for run in range(RUNS):
        answer = sum(own[NAMES.index(name), run] for name in hidden)
        left = -np.asarray(answer) + 0.3 * generator.standard_normal(SIZE)
        shared, nuisance = _smooth(generator, 5).T * 0.1, np.ones((SIZE, 1))
        designs.append(RunDesign(left, shared, nuisance, np.ones(SIZE)))
    observed = SimpleNamespace(
        time_s=np.arange(TIMES),
        channels=("a", "b", "c"),
        tolerance=np.ones(CHANNELS),
        weights=np.ones((TIMES, CHANNELS)),
    )
    screen = Screen(NormalMatrices.of(designs, tried))
    scores = screen.scores(ResidualSets.of(designs, tried, [d.residual[None] for d in designs]))
    order = np.argsort(-scores.loro_gain[0].sum(axis=0))
    baseline = SimpleNamespace(
        designs=tuple(designs),
        observed=(observed,) * RUNS,
        loro_cost=scores.loro_cost[0],
        pieces=RUNS * CHANNELS,
        position=lambda: np.zeros(0),
    )
    return baseline, tried, {NAMES[i]: int(i) for i in order}


def test_one_in_force_is_one_more_shared_column() -> None:
    baseline, tried, _ = _case(("windage", "cutting_heat"))
    residuals = [design.residual[None] for design in baseline.designs]
    grams = NormalMatrices.of(baseline.designs, tried, between=True)
    data = ResidualSets.of(baseline.designs, tried, residuals)
    quick = Screen(grams.beside(1)).scores(data.beside(1))
    wider = [
        replace(design, shared=np.column_stack([design.shared, MOST * tried[1].answers[run]]))
        for run, design in enumerate(baseline.designs)
    ]
    plain = Screen(NormalMatrices.of(wider, tried)).scores(ResidualSets.of(wider, tried, residuals))
    np.testing.assert_allclose(quick.loro_cost, plain.loro_cost, rtol=1e-8)
    others = [0, 2, 3]
    np.testing.assert_allclose(
        quick.loro_gain[..., others], plain.loro_gain[..., others], rtol=1e-6, atol=1e-6
    )


def test_the_pair_is_proposed_where_a_third_effect_explains_most_alone() -> None:
    baseline, tried, best = _case(("windage", "cutting_heat"))
    assert next(iter(best)) == "radiation"
    (pair,) = screened_pairs(baseline, tried, best, ("radiation",), 0)[:1]
    assert {tried[pair.first].key, tried[pair.second].key} == {"windage", "cutting_heat"}
    assert pair.cost < 0.2 * baseline.loro_cost.sum()
    assert 0.0 < pair.null_q99 < 0.8
    # The order in which they were found does not matter, and what they explain is found already.
    for found in (("windage", "cutting_heat"), ("cutting_heat", "windage")):
        assert screened_pairs(baseline, tried, best, found, 0) == []


def test_no_pair_is_proposed_where_one_effect_does() -> None:
    baseline, tried, best = _case(("copper_loss",))
    assert next(iter(best)) == "copper_loss"
    assert screened_pairs(baseline, tried, best, ("copper_loss",), 0) == []


def _begun(truth: Machine, told: Machine) -> tuple[CandidateFit, list[RunSensitivities]]:
    observed = observe(told, runs_of(truth))
    calibration = calibrate(told, observed, starts=1)
    sensitivities = all_sensitivities(told, calibration.machine, observed)
    return score_fit(told, (), observed, calibration, sensitivities), sensitivities


@pytest.mark.long
def test_two_are_named_though_neither_would_be_alone(jig_borer_lumps: Machine) -> None:
    truth = with_effect(jig_borer_lumps, "windage", {"power": 700.0})
    truth = with_effect(truth, "centrifugal_shift", {"shift": 40.0})
    before, sensitivities = _begun(truth, jig_borer_lumps)
    with ThreadPoolExecutor(1) as pool:
        alone, _ = select_effects(
            pool, before, sensitivities, replace(ASKED, most_effects=1), quiet
        )
        rounds, after = select_effects(pool, before, sensitivities, ASKED, quiet)
    assert [one.one_of for one in alone] == [()]
    assert [one.one_of for one in rounds] == [("centrifugal_shift",), ("windage",)]
    assert after.added == ("centrifugal_shift", "windage")
    assert after.loro_cost.sum() < 0.1 * before.loro_cost.sum()
    power = after.machine.parameters["effects.windage.power"].value
    assert power == pytest.approx(700.0, rel=0.25)


@pytest.mark.long
def test_a_pair_is_not_named_where_only_one_is_there(jig_borer_lumps: Machine) -> None:
    truth = with_effect(jig_borer_lumps, "windage", {"power": 700.0})
    before, sensitivities = _begun(truth, jig_borer_lumps)
    with ThreadPoolExecutor(1) as pool:
        at_first = float(before.loro_cost.sum())
        known = _round(pool, before, sensitivities, at_first, ASKED, quiet)
        places = [known[1].best[name] for name in ("centrifugal_shift", "windage")]
        # As if the screening had proposed the two.
        pair = ProposedPair(*places, 0.0, 0.1)
        assert _both(pool, before, sensitivities, known, pair, ASKED, quiet) is None


def test_two_that_cannot_be_put_together_are_compared_by_the_better_one() -> None:
    some = [Candidate(name, {}, ()) for name in NAMES[:2]]
    costs = np.full((2, 2), np.inf)
    assert _left_by(NAMES[:2], some, 9.0, np.array([3.0, 5.0]), costs) == 3.0
    costs[1, 0] = 2.0
    assert _left_by(NAMES[:2], some, 9.0, np.array([3.0, 5.0]), costs) == 2.0
