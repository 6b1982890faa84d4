"""Slips are seen in the data, and put into the model where it would slip at other instants."""

from dataclasses import replace

import numpy as np
import pytest

from gap_finder.candidates import with_effect
from gap_finder.leaps import leaps_in
from gap_finder.linearise import modelled, simulate_at
from gap_finder.observations import Observations, observe
from plant_model.machine import Machine
from tests.gap_finder.conftest import candidates_of, runs_of

KEY = "bearing_stick_slip"


@pytest.fixture(scope="module")
def slipping(jig_borer_lumps: Machine) -> list[Observations]:
    """Runs of a machine whose floating bearing slips."""
    machine = with_effect(jig_borer_lumps, KEY, {"hold": 9.0, "share": 0.6})
    return observe(jig_borer_lumps, runs_of(machine, seed=0))


def elongation_shown(machine: Machine, observed: Observations) -> np.ndarray:
    return modelled(simulate_at(machine, observed), observed)[0, :, -1]


def test_a_model_that_holds_too_long_slips_where_it_was_seen_to(jig_borer_lumps, slipping):
    wrong = with_effect(jig_borer_lumps, KEY, {"hold": 12.0, "share": 0.45})
    by_law = by_sight = 0.0
    for observed in slipping:
        base = modelled(simulate_at(jig_borer_lumps, observed), observed)[0]
        marked = leaps_in(jig_borer_lumps, observed, base).marked(observed, KEY)
        measured = observed.values[:, -1]
        by_law += float(np.sum((elongation_shown(wrong, observed) - measured) ** 2))
        by_sight += float(np.sum((elongation_shown(wrong, marked) - measured) ** 2))
    assert by_sight < 0.6 * by_law


def test_a_leap_against_the_strain_is_no_slip(jig_borer_lumps, slipping):
    observed = slipping[0]
    base = modelled(simulate_at(jig_borer_lumps, observed), observed)[0]
    leaps = leaps_in(jig_borer_lumps, observed, base)
    wrong_way = replace(leaps, sign=-leaps.sign).marked(observed, KEY)
    machine = with_effect(jig_borer_lumps, KEY, {"hold": 40.0, "share": 0.6})
    assert np.array_equal(elongation_shown(machine, wrong_way), elongation_shown(machine, observed))


def test_candidates_carry_what_was_seen_to_every_run(jig_borer_lumps, slipping):
    found = candidates_of(jig_borer_lumps, slipping, KEY)
    assert found
    one = found[0]
    assert len(one.seen) == len(slipping)
    seen = one.marked(0, slipping[0]).drive.held[f"{KEY} leaps"]
    assert np.count_nonzero(seen) == len(one.seen[0].sign)
    # Its answer grows with the share that reaches the nose, not with what holds.
    assert one.scaled(1.5).values["share"] == pytest.approx(0.75)
    assert one.scaled(1.5).values["hold"] == one.values["hold"]
