"""Mistakes of the shipped lathe's description, one kind after another, found with their place."""

import pytest

from benchmarks.gap.mistakes import mistakes, runs_of
from gap_finder.find import find_gap
from gap_finder.kinds.heat_source import HeatSource
from gap_finder.search import Search
from measurement.runs import Run
from plant_model.effects import catalogue
from plant_model.machine import Machine
from plant_model.machine_file import read_machine
from plant_model.simulate import simulate
from tests.gap_finder.conftest import inputs_of

LATHE = read_machine("lathe")
PLANTED = {
    ("conductance_with_motion", "z_nut", "air", "feed"),
    ("coarse_part", "carriage"),
}
FOUND = [
    pytest.param(one, id="-".join(key))
    for one in mistakes(LATHE)
    if (key := (one.kind, *one.place)) in PLANTED
]


ONLY_THE_DESCRIPTION = Search(tuple(catalogue()), most=1, workers=1)


@pytest.mark.long
@pytest.mark.parametrize("mistake", FOUND)
def test_a_mistake_is_named_with_its_place(mistake):
    found = find_gap(mistake.told, runs_of(mistake.truth)[:5], ONLY_THE_DESCRIPTION)
    assert found.keys == (":".join((mistake.kind, "+".join(mistake.place))),)


@pytest.mark.long
def test_nothing_is_named_where_the_description_is_right():
    assert find_gap(LATHE, runs_of(LATHE)[:5], ONLY_THE_DESCRIPTION).keys == ()


def four_runs(machine: Machine) -> list[Run]:
    return [
        Run(spectrum, simulate(machine, inputs_of(spectrum, 60.0), noise_seed=seed).run_frame())
        for seed, spectrum in enumerate(("down", "stairs", "stops", "steady"))
    ]


@pytest.mark.parametrize(("part", "within"), [("pedestal", 0.3), ("stator", 0.5)])
def test_a_missing_source_is_named_with_the_power_of_its_input(part, within, jig_borer_lumps):
    # The speed heats the stator already, in proportion, which leaves the exponent less certain.
    missing = HeatSource((part, "speed"))
    truth = missing.put_into(jig_borer_lumps, {"power": 400.0, "exponent": 2.5})
    found = find_gap(jig_borer_lumps, four_runs(truth), ONLY_THE_DESCRIPTION)
    assert found.keys == (missing.key,)
    assert missing.read(found.after.machine)["exponent"] == pytest.approx(2.5, abs=within)


def test_the_wrong_locating_bearing_is_named(jig_borer_lumps):
    name = "structure.front_bearing.at"
    told = jig_borer_lumps.with_values({name: -100.0}, beyond=True)
    found = find_gap(told, four_runs(jig_borer_lumps), ONLY_THE_DESCRIPTION)
    assert found.keys == ("locating_bearing:to_nose",)
    assert found.after.machine.parameters[name].value == pytest.approx(300.0, abs=50.0)
