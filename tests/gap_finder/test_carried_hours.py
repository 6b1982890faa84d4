"""Bearings that run in once: what earlier runs turned counts in those after them."""

from dataclasses import replace

import numpy as np
import pytest

from gap_finder.calibrate import calibrate
from gap_finder.candidates import grid, with_effect
from gap_finder.design import all_sensitivities
from gap_finder.forward_backward import Hypothesis, added_to
from gap_finder.keys import unused_with
from gap_finder.long_log import is_piece, pieces_of
from gap_finder.observations import observe
from gap_finder.proposals import Proposal
from gap_finder.score import scored
from measurement.runs import Run
from plant_model.effects import catalogue
from plant_model.simulate import simulate
from tests.gap_finder.conftest import candidates_of, inputs_of, runs_of

SERIES = "bearing_run_in:series"
HOURS = {"down": 2.2, "stairs": 3.0, "stops": 2.1}
"""Of three hours each: how long its spectrum turns."""


def test_every_run_has_the_hours_before_it_and_the_machine_those_of_all(jig_borer_lumps):
    observed = observe(jig_borer_lumps, runs_of(jig_borer_lumps)[:3])
    found = candidates_of(jig_borer_lumps, observed, "bearing_run_in")
    some = next(one for one in found if one.key == SERIES)
    before = [entry["before"] for entry in some.own]
    assert before[0] == 0.0
    assert before[1] > 1.5
    assert some.values["before"] > before[-1] + 1.5
    marked = some.marked(1, observed[1])
    assert marked.own == {f"effects.{SERIES}.before": before[1]}
    usual = next(one for one in found if one.key == "bearing_run_in")
    assert usual.own == ()
    # A later run churns less than the same run at first.
    size = [float(np.abs(answer).max()) for answer in some.answers]
    alone = [float(np.abs(answer).max()) for answer in usual.answers]
    assert size[0] == pytest.approx(alone[0])
    assert size[2] < 0.5 * alone[2]


def test_hours_that_runs_say_are_neither_tried_nor_fitted(jig_borer_lumps):
    assert "before" in unused_with(jig_borer_lumps, SERIES)
    assert "before" in unused_with(jig_borer_lumps, "bearing_run_in")
    effect = catalogue()["bearing_run_in"]
    assert {entry["before"] for entry in grid(effect, unused_with(jig_borer_lumps, SERIES))} == {
        0.0
    }
    assert not with_effect(jig_borer_lumps, SERIES).effects[SERIES]["before"].calibrate


def test_pieces_of_a_log_carry_their_hours_by_themselves(jig_borer_lumps):
    frame = simulate(jig_borer_lumps, inputs_of("down")).run_frame()
    pieces = pieces_of(jig_borer_lumps, Run("week", frame), 1.0)
    assert [is_piece(one) for one in (*pieces, Run("week_of_may", frame))] == [True] * 3 + [False]
    keys = {
        one.key: one.own
        for one in candidates_of(
            jig_borer_lumps, observe(jig_borer_lumps, pieces), "bearing_run_in"
        )
    }
    assert set(keys.values()) == {()}


def test_the_hours_of_all_runs_are_written_into_the_machine(jig_borer_lumps):
    truth = with_effect(jig_borer_lumps, SERIES, {"excess": 1.0, "hours": 3.0})
    shown, before = [], 0.0
    for run in runs_of(jig_borer_lumps)[:2]:
        aged = truth.with_values({f"effects.{SERIES}.before": before})
        frame = simulate(aged, run.frame, noise_seed=3).run_frame()
        shown.append(replace(run, frame=frame))
        before += HOURS[run.name]
    observed = observe(jig_borer_lumps, shown)
    calibration = calibrate(jig_borer_lumps, observed, starts=1, cost_limit=0.0)
    sensitivities = all_sensitivities(calibration.machine, observed)
    now = scored(jig_borer_lumps, observed, calibration, sensitivities)
    found = candidates_of(now.machine, observed, "bearing_run_in")
    some = next(one for one in found if one.key == SERIES and one.values["excess"] > 0.5)
    grown = added_to(Hypothesis((), (), now), Proposal(some, now.machine, 10.0), sensitivities)
    assert grown is not None
    fit = grown.fit
    assert fit.machine.effects[SERIES]["before"].value == pytest.approx(before, abs=0.05)
    assert [one.own[f"effects.{SERIES}.before"] for one in fit.observed] == [
        0.0,
        pytest.approx(HOURS["down"], abs=0.02),
    ]
    assert fit.cost < now.cost
