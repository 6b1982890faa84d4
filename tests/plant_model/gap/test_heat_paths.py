"""Heat paths that the machine file forgot."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path as File

import pytest

from plant_model.effects import catalogue
from plant_model.gap.heat_paths import Path, _paths
from plant_model.gap.held_out import answer
from plant_model.gap.report import five_lines, report_of
from plant_model.machine import Machine
from plant_model.machine_file import read_machine
from plant_model.machine_writer import write_machine
from tests.plant_model.gap.conftest import runs_of

FORGOTTEN = ("front_inner", "front_outer")


def without_link(machine: Machine, name: str) -> Machine:
    return replace(machine, items=tuple(item for item in machine.items if item.name != name))


def test_every_pair_that_is_not_joined_is_tried(jig_borer: Machine) -> None:
    joined = {frozenset(item.refs["between"]) for item in jig_borer.items if "between" in item.refs}
    places = [frozenset(path.place) for path in _paths(jig_borer)]
    assert len(places) == len(set(places))
    assert not joined & set(places)
    nodes = len(jig_borer.nodes)
    every = nodes * (nodes - 1) // 2 + nodes * len(jig_borer.boundary_index)
    assert len(places) + len(joined) == every


@pytest.mark.parametrize(
    "path",
    [Path(("rotor", "housing_rear"), boundary=False), Path(("stator", "ambient"), boundary=True)],
)
def test_a_path_is_written_and_read_back(path: Path, jig_borer: Machine, tmp_path: File) -> None:
    grown = path.put_into(jig_borer, 12.0)
    assert grown.parameters[path.parameter].value == 12.0
    file = write_machine(grown, "jig_borer", tmp_path / "after.toml")
    assert read_machine(file) == grown
    assert set(grown.parameters) - set(jig_borer.parameters) >= {path.parameter}


@pytest.mark.slow
def test_a_forgotten_path_is_named_with_its_place(jig_borer: Machine) -> None:
    few = ("centrifugal_shift",)
    without = [name for name in catalogue() if name not in few]
    told_wrong = without_link(jig_borer, "-".join(FORGOTTEN))
    runs = runs_of(jig_borer, every_s=60.0)
    found, comparison, faults = answer(told_wrong, runs[:3], runs[3:], without=without, workers=1)
    table = report_of(found, comparison, faults)
    (effect,) = table["effects"]
    assert effect["name"] == "heat_path"
    assert effect["place"] == list(FORGOTTEN) or list(FORGOTTEN) in effect["other_places"]
    gap = table["gap"]["holdout"]
    assert gap["after"] < 0.6 * gap["before"]
    assert "Heat path" in five_lines(table)[1]
