"""What one hypothesis must win against another."""

from concurrent.futures import Future
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from gap_finder import forward_backward
from gap_finder.forward_backward import (
    MARGIN,
    Hypothesis,
    Searching,
    Step,
    units_of,
)
from gap_finder.score import LAW, Units
from gap_finder.search import Search

DETERMINED = 10.0


def moved_by(squares: float) -> dict[str, float]:
    """Return how far a fit's unknowns moved; its runs determine ten of the file's numbers."""
    return {
        "numbers_moved": squares,
        "others_moved": 0.0,
        "determined": DETERMINED,
    }


def hypothesis(
    left: Any, calibrated: float = 0.0, prior: float = 0.0, moved: float = 0.0
) -> Hypothesis:
    """Return one with what it leaves (R, C), the cost of its calibration, and what it costs."""
    calibration = SimpleNamespace(cost=calibrated, starts_cost=0.0)
    fit: Any = SimpleNamespace(left=np.asarray(left), calibration=calibration, **moved_by(moved))
    return Hypothesis((), (prior,), fit)


def test_what_is_missing_in_one_channel_hides_nothing_in_another():
    nothing = hypothesis([[400.0, 12.0], [600.0, 8.0]])
    first = hypothesis([[2.0, 11.0], [2.0, 9.0]])
    second = hypothesis([[2.0, 1.0], [2.0, 1.0]])
    units = units_of(nothing, [first, second])
    np.testing.assert_allclose(units.channels, [LAW * 500.0, 1.0])
    assert first.cost_left_out(units) - second.cost_left_out(units) == pytest.approx(18.0)


@pytest.mark.parametrize(("spared", "falls"), [(60.0, 10.0), (100.0, 50.0), (118.0, 118.0)])
def test_sparing_the_numbers_counts_by_how_far_off_they_then_still_are(spared, falls):
    """In a file that is wrong with any name, 60 of 120 say little; what spares all 120 is right."""
    nothing = hypothesis([[1.0]], moved=120.0)
    sparing = hypothesis([[1.0]], moved=120.0 - spared)
    units = units_of(nothing, [nothing, sparing])
    assert nothing.cost_left_out(units) - sparing.cost_left_out(units) == pytest.approx(falls)


def test_a_file_without_free_numbers_has_a_unit():
    nothing = hypothesis([[1.0]])
    fixed = replace(nothing, fit=SimpleNamespace(**vars(nothing.fit) | {"determined": 0.0}))
    assert units_of(fixed, [fixed]).numbers == 1.0


PLAIN = Units(np.ones(1), 1.0)


@pytest.mark.parametrize(
    ("left_out", "calibrated_on", "better"),
    [
        (7.7, 0.3, False),
        (6.1, 5.8, False),
        (6.1, 6.1, True),
        (20.4, 2.7, True),
        (MARGIN, 30.0, False),
    ],
)
def test_left_out_runs_alone_and_with_calibration_runs_exclude_another(
    left_out, calibrated_on, better
):
    prior = 15.9
    before = hypothesis([[100.0]], calibrated=100.0)
    left, cost = 100.0 - left_out - prior, 100.0 - calibrated_on - prior
    after = hypothesis([[left]], calibrated=cost, prior=prior)
    assert after.is_better(before, PLAIN) is better


def test_of_two_that_predict_alike_the_one_that_fits_better_wins():
    """Errors of a law are forgiven on left-out runs: the one that acts like it costs no more."""
    nothing = hypothesis([[5200.0]], calibrated=350.0)
    imitator = hypothesis([[1600.0]], calibrated=290.0, prior=16.0)
    right = hypothesis([[2.0]], calibrated=65.0, prior=47.0)
    units = units_of(nothing, [nothing, imitator, right])
    assert imitator.cost_left_out(units) < right.cost_left_out(units)
    assert right.score(units) < imitator.score(units) - MARGIN


class GoingRound(Searching):
    """Adds what is not there, and takes away what was."""

    steps = 0

    def _listed(self, best, sensitivities):
        return SimpleNamespace(without=lambda keys: (), silent=())

    def _forward(self, best, sensitivities, listed):
        self.steps += 1
        assert self.steps < 9, "goes round for ever"
        added = "b" if best.keys == ("a",) else "a"
        return Step(best, (named(*best.keys, added, left=best.fit.left - 40.0),), PLAIN)

    def _settled(self, best, tried, sensitivities):
        return named(best.keys[-1], left=500.0), ((),)


def named(*keys: str, left: Any) -> Hypothesis:
    machine = SimpleNamespace(node_index={})
    fit: Any = SimpleNamespace(
        left=np.full((1, 1), left),
        machine=machine,
        calibration=SimpleNamespace(cost=float(np.sum(left)), starts_cost=0.0),
        **moved_by(0.0),
    )
    parts: Any = tuple(SimpleNamespace(key=key, size_cost=lambda: 0.0) for key in keys)
    return Hypothesis(parts, (0.0,) * len(keys), fit)


def test_a_search_that_goes_round_ends(monkeypatch):
    monkeypatch.setattr(forward_backward, "recalibrated", lambda best, pool: (best, []))
    nothing = named(left=540.0).fit
    found = GoingRound(None, nothing, Search(), lambda text: None).run([])  # type: ignore[arg-type]
    assert [step.tried[0].keys for step in found.steps] == [("a",), ("a", "b"), ("b", "a")]


LEFT = {("c", "b"): 20.0, ("c", "d"): 23.0}


class Exchanging(Searching):
    """Scores every pair by a table instead of calibrating it."""

    def _exchanged(self, best, place, rival, sensitivities):
        keys = [*best.keys]
        keys[place : place + 1] = [] if rival is None else [rival.keys[-1]]
        done: Future[Hypothesis | None] = Future()
        done.set_result(named(*keys, left=LEFT.get(tuple(keys), 500.0)))
        return done


def test_after_a_swap_the_last_ones_rivals_are_asked_again_beside_what_came_in():
    """They were scored beside what went out."""
    nothing = named(left=600.0)
    first = (named("a", left=400.0), named("c", left=410.0))
    second = (named("a", "b", left=50.0), named("a", "d", left=55.0))
    search = Exchanging(None, nothing.fit, Search(), lambda text: None)  # type: ignore[arg-type]
    best, rivals = search._settled(second[0], {"a": first, "b": second}, [])
    assert best.keys == ("c", "b")
    assert [[rival.keys for rival in there] for there in rivals] == [[], [("c", "d")]]


class Sizing(Searching):
    """Scores a law at two sizes, another one between them."""

    sizes = (named("a", left=100.0), named("b", left=110.0), named("a", left=120.0))
    scored = iter([[*sizes], [], []])

    def _scored(self, best, proposed, sensitivities, leader=None, cost_limit=0.0):
        return next(self.scored)


def test_a_law_tried_at_several_sizes_stands_for_itself_once_at_its_best(monkeypatch):
    monkeypatch.setattr(forward_backward, "screened", lambda *args: ([], []))
    nothing, nowhere = named(left=5400.0), SimpleNamespace()
    search = Sizing(None, nothing.fit, Search(), lambda text: None)  # type: ignore[arg-type]
    step = search._forward(nothing, [], nowhere)  # type: ignore[arg-type]
    assert [(one.keys, float(one.fit.left[0, 0])) for one in step.tried] == [
        (("a",), 100.0),
        (("b",), 110.0),
    ]
