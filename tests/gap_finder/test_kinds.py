"""Every kind of change of a description: tried where it can be, written, read, and found."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from gap_finder.candidates import with_effect
from gap_finder.design import all_sensitivities
from gap_finder.hypotheses import AddedChange
from gap_finder.keys import has_its_drivers
from gap_finder.kinds import CalibratedRun, Change, base, kinds
from gap_finder.kinds.heat_source import HeatSource
from gap_finder.kinds.locating_bearing import WAYS
from gap_finder.kinds.moves_axis import MovesAxis
from gap_finder.linearise import modelled, simulate_at, simulate_runs
from gap_finder.observations import observe
from plant_model.integrate import IntegrationError
from plant_model.machine import Input, Machine
from plant_model.machine_file import read_machine
from plant_model.machine_writer import write_machine
from plant_model.network import effects_in_force
from plant_model.parameters import Values
from plant_model.simulate import Simulation, simulate
from plant_model.stepper import PlantStepper
from tests.gap_finder.conftest import inputs_of
from tests.gap_finder.test_start_states import warm_runs

NAMES = tuple(kinds())
NEVER_OFF = ("coarse_part", "start_state")


@pytest.fixture(scope="module")
def known(jig_borer_lumps: Machine) -> list[CalibratedRun]:
    observed = observe(jig_borer_lumps, warm_runs(jig_borer_lumps)[1:3])
    sensitivities = all_sensitivities(jig_borer_lumps, observed)
    simulated = simulate_runs(jig_borer_lumps, observed)
    return [
        CalibratedRun(jig_borer_lumps, *one)
        for one in zip(observed, simulated, sensitivities, strict=True)
    ]


def changes_of(name: str, known: list[CalibratedRun]) -> list[Change]:
    return list(kinds()[name].all_of(known))


@pytest.mark.parametrize("name", NAMES)
def test_every_place_is_tried_once_and_no_place_that_the_machine_has(name, known):
    changes = changes_of(name, known)
    assert changes
    assert len(set(changes)) == len(changes)
    parts = {node.name for node in known[0].machine.nodes}
    signals = {entry.name for entry in known[0].machine.inputs}
    signals |= {sensor.name for sensor in known[0].machine.sensors} | {"X", "Y", "Z"}
    for change in changes:
        assert change.name == name
        assert set(change.place) <= parts | signals | set(WAYS)
        assert change.points()


def test_a_door_that_an_input_tells_of_lets_in_the_hall(jig_borer_lumps, known):
    door = Input("door", "1", "door_1", 0.0, 1.0, 0.0)
    machine = replace(jig_borer_lumps, inputs=(*jig_borer_lumps.inputs, door))
    without = [replace(one, machine=machine) for one in known]
    assert not any("door" in one.place for one in changes_of("conductance_with_motion", without))
    frame = known[0].observed.run.frame.assign(door_1=0.0)
    frame.loc[frame["time_s"] > 3600.0, "door_1"] = 1.0
    run = replace(known[0].observed.run, frame=frame)
    told = [replace(without[0], observed=replace(known[0].observed, run=run))]
    place = ("housing_rear", "ambient", "door")
    (change,) = (one for one in changes_of("conductance_with_motion", told) if one.place == place)
    draughty = change.put_into(machine, {"conductance": 20.0})
    hot = np.full((1, len(machine.nodes)), 40.0)
    open_, shut = (
        simulate(draughty, frame.assign(door_1=flag), start=hot).temperatures[0, -1]
        for flag in (1.0, 0.0)
    )
    rear = machine.node_index["housing_rear"]
    assert open_[rear] < shut[rear] - 1.0
    np.testing.assert_array_equal(
        shut, simulate(machine, frame.assign(door_1=0.0), start=hot).temperatures[0, -1]
    )


def test_a_part_in_two_has_half_of_its_surface_on_either_side(known):
    machine = known[0].machine
    in_two = {one.place[0]: one for one in changes_of("coarse_part", known)}
    films = [i for i in machine.of_kind("links", "convection") if i.refs["between"][0] in in_two]
    assert films
    for film in films:
        part, air = film.refs["between"]
        change = in_two[part]
        grown = change.put_into(machine, change.points()[-1])
        areas = {
            item.refs["between"]: item.parameters["area"].value
            for item in grown.of_kind("links", "convection")
            if item.name in (film.name, f"{film.name}_far")
        }
        half = 0.5 * film.parameters["area"].value
        assert areas == {(part, air): half, (f"{part}_far", air): half}


@pytest.mark.parametrize("name", NAMES)
def test_a_change_is_written_read_back_and_stepped(name, known, tmp_path):
    machine = known[0].machine
    changes = changes_of(name, known)
    for change in (changes[0], changes[-1]):
        numbers = change.points()[-1]
        grown = change.put_into(machine, numbers)
        assert change.read(grown) == pytest.approx(numbers)
        path = write_machine(grown, "jig_borer_lumps", tmp_path / "after.toml")
        assert read_machine(path) == grown
        assert Machine.from_dict(grown.to_dict()) == grown
        assert all(full in grown.parameters for full in change.parameters().values())
    stepper = PlantStepper(grown)
    stepper.reset({"ambient": 21.0, "coolant_inlet": 21.0, "speed": 0.0, "torque": 0.0}, {})
    assert np.isfinite(stepper.state()["start"]).all()


@pytest.mark.parametrize("name", NAMES)
def test_a_number_is_reported_as_the_change_reads_it(name, known):
    for change in (changes_of(name, known)[0], changes_of(name, known)[-1]):
        grown = change.put_into(known[0].machine, change.points()[-1])
        for number, value in change.read(grown).items():
            if number in change.parameters():
                given = grown.parameters[change.parameters()[number]]
                ends = {"value": given.value, "low": given.low, "high": given.high}
                shown = change.shown({**ends, "unit": given.unit})
                assert shown["value"] == pytest.approx(value)
                assert shown["low"] <= shown["value"] <= shown["high"]
                assert shown["unit"] == ("1" if number == "share" else given.unit)


@pytest.mark.parametrize("name", [name for name in NAMES if name != "start_state"])
def test_its_prior_is_the_same_wherever_the_search_begins(name, known):
    machine = known[0].machine
    change = changes_of(name, known)[0]
    begun = [AddedChange(change, change.scaled(one, 0.2), ()) for one in change.points()]
    first, *rest = [one.base(machine).parameters for one in begun]
    assert all(one == first for one in rest)
    if change.amplitude not in change.parameters():
        return
    low, high = change.possible(change.amplitude)
    number = first[change.parameters()[change.amplitude]]
    assert (number.low, number.high) == (low, high)
    assert number.value == pytest.approx(np.sqrt(low * high), rel=0.4)


@pytest.mark.parametrize("name", NAMES)
def test_what_is_screened_is_what_the_changed_machine_does(name, known):
    one = known[1]
    changes = changes_of(name, known)
    base = modelled(simulate_at(one.machine, one.observed), one.observed)
    answers = kinds()[name].answers(changes, [one])[0]
    assert len(answers) == len(changes)
    for at in np.linspace(0, len(changes) - 1, 5).astype(int):
        change, answer = changes[at], answers[at]
        assert answer.shape == (len(change.points()), base[0].size)
        for point, told in zip(change.points(), answer, strict=True):
            grown = change.put_into(one.machine, point)
            shown = modelled(simulate_at(grown, one.observed), one.observed)
            changed = ((shown - base)[0] * one.observed.weights).ravel()
            # A thermometer's tip starts at its reading, and needs a few seconds from there.
            later = slice(3 * len(one.observed.channels), None)
            close = 0.2 * np.abs(changed).max() + 1e-2
            np.testing.assert_allclose(told[later], changed[later], atol=close)


def test_a_change_that_cannot_be_stepped_leaves_the_others_alone(known, monkeypatch):
    def refusing(machine: Machine, *args: Any, **options: Any) -> list[Simulation]:
        if any(item.name == "heat_in_shaft_rear" for item in machine.items):
            raise IntegrationError("too stiff")
        return simulate_runs(machine, *args, **options)

    changes = changes_of("heat_source", known)[:9]
    assert ("shaft_rear",) in [change.place for change in changes]
    sound = HeatSource.answers(changes, known)
    monkeypatch.setattr(base, "simulate_runs", refusing)
    for of_run, usual in zip(HeatSource.answers(changes, known), sound, strict=True):
        for change, answer, before in zip(changes, of_run, usual, strict=True):
            lost = change.place == ("shaft_rear",)
            np.testing.assert_allclose(answer, 0.0 * before if lost else before, atol=1e-6)


@pytest.mark.parametrize("name", [name for name in NAMES if name not in NEVER_OFF])
def test_a_change_that_is_off_changes_nothing(name, known):
    machine = known[0].machine
    inputs = inputs_of("stairs", 60.0)
    change = changes_of(name, known)[:4][-1]
    off = change.put_into(machine, {**change.points()[0], change.amplitude: 0.0})
    plain, same = (simulate(one, inputs).run_frame() for one in (machine, off))
    np.testing.assert_allclose(same.to_numpy(), plain.to_numpy(), atol=0.05)


def test_the_locating_bearing_is_looked_for_as_far_as_shaft_and_housing_reach(known):
    machine = known[0].machine
    assert machine.parameters["structure.front_bearing.at"].value == 300.0
    to_nose, from_nose = changes_of("locating_bearing", known)
    assert to_nose.points()[-1] == {"moved": 320.0 - 300.0}
    assert from_nose.points()[-1] == {"moved": 300.0 + 140.0}
    # What calibration moves already is no change of the description.
    machine = from_nose.put_into(machine, {"moved": 100.0})
    assert not changes_of("locating_bearing", [replace(one, machine=machine) for one in known])


def test_a_change_that_takes_an_effects_driver_away_is_not_tried():
    # A heavier part that moves the nose is the column, and the bed is none.
    machine = with_effect(read_machine("lathe"), "fixture_warming:bed")
    assert has_its_drivers(machine)
    lost = []
    for node in machine.nodes:
        changed = MovesAxis((node.name, "Z"), 1.0).put_into(machine, {"length": 60.0})
        if has_its_drivers(changed):
            effects_in_force(changed, Values(changed.parameters))
        else:
            lost.append(node.name)
    assert lost == ["foot"]
