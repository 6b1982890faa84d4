"""Heat paths that the machine file forgot."""

from __future__ import annotations

from dataclasses import replace

import pytest

from gap_finder.five_lines import five_lines
from gap_finder.held_out import answer
from gap_finder.report import report_of
from gap_finder.search import Search
from plant_model.effects import catalogue
from plant_model.machine import Machine
from tests.gap_finder.conftest import runs_of

FORGOTTEN = ("front_inner", "front_outer")


def without_link(machine: Machine, name: str) -> Machine:
    return replace(machine, items=tuple(item for item in machine.items if item.name != name))


@pytest.mark.long
def test_a_forgotten_path_is_named_with_where_it_leads_from(jig_borer_lumps: Machine) -> None:
    few = ("centrifugal_shift",)
    without = [name for name in catalogue() if name not in few]
    told_wrong = without_link(jig_borer_lumps, "-".join(FORGOTTEN))
    runs = runs_of(jig_borer_lumps, every_s=60.0)
    found, comparison, faults = answer(told_wrong, runs[:3], runs[3:], Search(without, workers=1))
    table = report_of(found, comparison, faults)
    (effect,) = table["effects"]
    assert effect["name"] == "heat_path"
    # From the inner ring, or the shaft in it, to what is cooled outside: soft ranges of the other
    # numbers take up so much of it that the runs no longer tell where it ends.
    places = [effect["place"], *effect["other_places"]]
    assert all(place[0] in (FORGOTTEN[0], "shaft_front") for place in places)
    gap = table["gap"]["holdout"]
    assert gap["after"] < 0.75 * gap["before"]
    assert "Heat path" in five_lines(table)[1]
