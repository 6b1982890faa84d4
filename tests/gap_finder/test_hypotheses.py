"""The list of what may be missing and its prior."""

import numpy as np
import pytest

from gap_finder.candidates import Candidate, grid, missing_effects, with_effect
from gap_finder.hypotheses import Listed, prior_costs
from gap_finder.priors import heavy_tail
from plant_model.effects import catalogue
from plant_model.effects.base import possible


def test_half_is_nothing_and_every_kind_has_an_equal_part_of_the_rest():
    keys = ["windage", "slow_structure", "slow_structure:bed", *(f"heat_path:a+{i}" for i in "bcd")]
    odds = {key: np.exp(-cost / 2.0) for key, cost in prior_costs(keys, {}).items()}
    assert sum(odds.values()) == pytest.approx(1.0), "as likely as nothing, whose odds are 1"
    assert odds["windage"] == pytest.approx(2.0 * odds["slow_structure"])
    assert odds["windage"] == pytest.approx(3.0 * odds["heat_path:a+b"])


def test_a_finer_mesh_makes_no_other_place_less_likely():
    cells = {f"housing_{i}": "housing" for i in range(9)}
    coarse = prior_costs(["heat_path:housing+bed", "heat_path:head+bed"], {})
    fine = prior_costs([*(f"heat_path:{cell}+bed" for cell in cells), "heat_path:head+bed"], cells)
    assert fine["heat_path:head+bed"] == coarse["heat_path:head+bed"]
    odds = [np.exp(-fine[f"heat_path:{cell}+bed"] / 2.0) for cell in cells]
    assert sum(odds) == pytest.approx(np.exp(-coarse["heat_path:housing+bed"] / 2.0))


@pytest.mark.parametrize("value", [1.0, 3.0, 40.0])
def test_sizes_have_the_tail_of_a_cauchy_law(value):
    # A density 1 / (pi (1 + x^2)), about 1 and of scale 1.
    expected = 2.0 * np.log(1.0 + (value - 1.0) ** 2)
    assert heavy_tail(value, 0.0, 2.0, log=False) == pytest.approx(expected)
    assert heavy_tail(np.exp(value), 1.0, np.e**2, log=True) == pytest.approx(expected)


def test_hours_beyond_the_usual_are_possible_and_cost_something(jig_borer_lumps):
    effect = catalogue()["slow_structure"]
    usual = effect.parameters["hours"]
    machine = with_effect(jig_borer_lumps, "slow_structure", {"hours": 2.0 * usual.high})
    assert machine.effects["slow_structure"]["hours"].value == 2.0 * usual.high
    values = {name: one.value for name, one in effect.parameters.items()}
    costs = [
        Candidate("slow_structure", values | {"hours": hours}, ()).size_cost()
        for hours in (np.sqrt(usual.low * usual.high), usual.high, 2.0 * usual.high)
    ]
    assert costs[0] < costs[1] < costs[2]
    assert costs[1] - costs[0] == pytest.approx(2.0 * np.log(2.0))


def test_candidates_cover_both_signs_and_stay_possible(jig_borer_lumps):
    for effect in missing_effects(jig_borer_lumps):
        sizes = {entry[effect.amplitude] for entry in grid(effect)}
        amplitude = effect.parameters[effect.amplitude]
        assert effect.off not in sizes
        assert (min(sizes) < effect.off) == (amplitude.low < effect.off)
        for entry in grid(effect):
            for name, value in entry.items():
                low, high = possible(effect, name)
                assert low <= value <= high


def test_what_is_added_leaves_the_list_with_its_law_on_every_driver():
    keys = ["slow_structure", "slow_structure:bed", "sensor_lag:T1", "sensor_lag:T2", "windage"]
    tried = [Candidate(key, {}, ()) for key in keys]
    rest = Listed(tried, prior_costs(keys, {})).without(["slow_structure:bed", "sensor_lag:T2"])
    assert [one.key for one in rest.tried] == ["sensor_lag:T1", "windage"]
    assert rest.costs == prior_costs(["sensor_lag:T1", "windage"], {})
