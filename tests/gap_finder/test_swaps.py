"""Of two missing effects, the first is chosen anew once the second is known."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from gap_finder.calibrate import calibrate
from gap_finder.candidates import candidates, with_effect
from gap_finder.design import all_sensitivities
from gap_finder.observations import observe
from gap_finder.refit import fit_candidate, refit_in_full, score_fit
from gap_finder.selection import SelectionRound
from gap_finder.swaps import swapped
from plant_model.effects import catalogue
from plant_model.machine import Machine
from tests.gap_finder.conftest import runs_of

TRUE = {"windage": {"power": 250.0}, "centrifugal_shift": {"shift": 12.0}}


@pytest.mark.long
def test_a_neighbour_named_first_gives_way_beside_the_second(jig_borer_lumps: Machine) -> None:
    truth = jig_borer_lumps
    for key, values in TRUE.items():
        truth = with_effect(truth, key, values)
    observed = observe(jig_borer_lumps, runs_of(truth))
    calibration = calibrate(jig_borer_lumps, observed, starts=1)
    sensitivities = all_sensitivities(jig_borer_lumps, calibration.machine, observed)
    before = score_fit(jig_borer_lumps, (), observed, calibration, sensitivities)

    def tried(now, key):  # type: ignore[no-untyped-def]
        found = list(candidates(now.machine, now.observed, catalogue()[key]))
        one = found[len(found) // 2]
        return fit_candidate(now, one, 1.0, np.full(len(observed), np.inf), sensitivities)

    neighbour, right = (tried(before, key) for key in ("friction_speed_exponent", "windage"))
    # As if the first round had preferred the neighbour.
    first = SelectionRound(
        before, (neighbour, right), (0.6, 0.4), 0.5, 0.1, (*neighbour.added, *right.added), True
    )
    both, around_both = refit_in_full(tried(neighbour, "centrifugal_shift"))
    again, after = swapped(first, both, around_both)
    assert again.one_of == ("windage",)
    assert again.best is right
    share = 1.0 - right.loro_cost.sum() / before.loro_cost.sum()
    assert again.explained_share == pytest.approx(share)
    assert after.added == ("windage", "centrifugal_shift")
    assert after.cost < both.cost
    power = after.machine.parameters["effects.windage.power"].value
    assert power == pytest.approx(250.0, rel=0.25)
    # With no rival there is nothing to ask.
    alone = replace(first, one_of=first.one_of[:1])
    assert swapped(alone, both, around_both) == (alone, both)
