"""One law with several drivers: what each follows, and how machine files name it."""

from dataclasses import replace

import numpy as np
import pytest

from gap_finder.candidates import missing_effects, with_effect
from gap_finder.keys import driver_keys, driver_of, law_of, unused_with
from plant_model.anatomy import enclosed_air, structure_parts
from plant_model.effects import catalogue
from plant_model.effects.base import NONE
from plant_model.machine_file import machine_path, read_machine
from plant_model.network import effects_in_force
from plant_model.parameters import Values
from tests.plant_model.catalogue_machines import bare, change, heat_of, made, steady
from tests.plant_model.conftest import with_effects
from tests.plant_model.test_catalogue_readings import hall_step
from tests.refusing import refusal


def test_a_law_is_the_same_whatever_drives_it(jig_borer_lumps):
    keys = ("slow_structure:column", "sensor_lag:T1", "slow_structure", "heat_path:a+b")
    laws = ["slow_structure", "sensor_lag:T1", "slow_structure", "heat_path:a+b"]
    assert [law_of(key) for key in keys] == laws
    assert driver_of(jig_borer_lumps, "slow_structure") == ("hall", "the hall")
    assert driver_of(jig_borer_lumps, "slow_structure:column") == (
        "column",
        "the column and the hall",
    )
    assert driver_of(jig_borer_lumps, "slow_structure:gone") == ("gone", "the gone")
    assert (
        driver_of(jig_borer_lumps, "sensor_lag:T1")
        == driver_of(jig_borer_lumps, "windage")
        == ("", "")
    )
    assert driver_keys(jig_borer_lumps, catalogue()["windage"]) == ["windage"]


def test_one_driver_in_force_leaves_no_other_to_be_missed(jig_borer_lumps):
    machine = with_effect(jig_borer_lumps, "slow_structure:column")
    assert catalogue()["slow_structure"] not in missing_effects(machine)
    assert catalogue()["sensor_lag"] in missing_effects(with_effect(machine, "sensor_lag:T1"))


def test_a_foot_that_does_not_move_the_nose_is_not_the_column():
    assert structure_parts(read_machine("lathe")) == ["bed", "bed_head"]  # not the heavier foot


def test_what_a_driver_does_not_use_is_not_calibrated(jig_borer_lumps):
    assert unused_with(jig_borer_lumps, "column_bending:hall") == ("carrier_share",)
    assert (
        unused_with(jig_borer_lumps, "column_bending")
        == unused_with(jig_borer_lumps, "sensor_lag:T1")
        == ()
    )
    moved = with_effect(jig_borer_lumps, "column_bending:hall").effects["column_bending:hall"]
    assert [name for name, p in moved.items() if not p.calibrate] == ["carrier_share"]


@pytest.mark.parametrize(
    ("key", "problem"),
    [
        ("slow_structure:rotor", "rotor"),
        ("windage:column", "windage does not act on one sensor"),
        ("thermal_preload:", ""),
    ],
)
def test_a_driver_that_is_none_is_refused(key, problem, jig_borer_lumps, tmp_path):
    text = machine_path("jig_borer_lumps").read_text(encoding="utf-8")
    (tmp_path / "odd.toml").write_text(f'{text}\n[effects."{key}"]\n', encoding="utf-8")
    if not problem:
        assert key in read_machine(tmp_path / "odd.toml").effects
        return
    assert problem in refusal(read_machine, tmp_path / "odd.toml")


def test_thermal_preload_follows_the_mean_of_a_housing_in_sectors(jig_borer_lumps):
    # The jig borer's front bearing touches a quarter of the housing on each side: their mean.
    _, effect = made(jig_borer_lumps, "thermal_preload:shaft_housing", gain=0.1)
    one, all_four = (
        heat_of(effect, 3000.0, dict.fromkeys(names, 16.0))["front_inner"]
        for names in (
            ["housing_front_xp"],
            [f"housing_front_{side}" for side in ("xp", "xm", "yp", "ym")],
        )
    )
    assert one == pytest.approx(all_four / 4.0)
    assert one > 0.0


def test_the_air_of_an_enclosure_is_the_part_with_most_contacts(jig_borer_lumps):
    for one in (read_machine("jig_borer"), jig_borer_lumps, bare()):
        assert enclosed_air(one) is None
    forced = catalogue()["forced_convection"]
    for name, air in (("lathe", "air"), ("belt_spindle", "enclosure_air")):
        machine = read_machine(name)
        assert enclosed_air(machine) == air
        assert list(forced.drivers(machine)) == ["outside", air]
    # A part that grows is none, however many others it touches.
    lengths = [item for item in machine.items if item.family == "structure"]
    grows = replace(lengths[0], name="grows", refs={"nodes": (air,)})
    assert enclosed_air(replace(machine, items=(*machine.items, grows))) != air
    # Nor is a solid part, whose heat capacity follows from a drawing.
    drawn = [
        replace(node, capacity=replace(node.capacity, tied="numbers.steel_heat"))
        if node.name == air
        else node
        for node in machine.nodes
    ]
    assert enclosed_air(replace(machine, nodes=tuple(drawn))) != air
    assert list(forced.drivers(jig_borer_lumps)) == []


def test_forced_convection_stirs_the_air_that_drives_it():
    machine = read_machine("lathe")
    _, effect = made(machine, "forced_convection:air", gain=2.0)
    (speed,) = (entry for entry in machine.inputs if entry.unit == "rpm")
    contacts = [one for one in machine.of_kind("links", "contact") if "air" in one.refs["between"]]
    for share in (0.0, 0.5, 1.0):
        stirred = effect.conductance({"speed": np.array([share * speed.high])}, NONE, NONE)
        assert len(stirred) == len(contacts)
        for one, item in zip(stirred, contacts, strict=True):
            assert {one.node, one.other} == {machine.node_index[n] for n in item.refs["between"]}
            at_rest = item.parameters["conductance"].value
            assert one.conductance[0, 0] == pytest.approx(2.0 * at_rest * share**0.7)
    # Outside it is the hall's air, as ever.
    _, effect = made(machine, "forced_convection", gain=2.0)
    stirred = effect.conductance({"speed": np.array([speed.high])}, NONE, NONE)
    assert stirred
    assert all(one.boundary for one in stirred)


def test_slow_structure_follows_the_part_that_drives_it(jig_borer_lumps):
    inputs = steady(12000.0, 6.0)
    own = {"growth": 5.0, "hours": 3.0}
    by_part = change(jig_borer_lumps, "slow_structure:pedestal", inputs, **own, part_share=1.0)
    by_hall = change(jig_borer_lumps, "slow_structure", inputs, **own)
    with_it, without = by_part[1:]
    grown = (with_it.pose - without.pose)[0, :, 2]
    warmed = without.temperatures[0, :, jig_borer_lumps.node_index["pedestal"]]
    # 3 h behind a part that warms: less than it would be at once, and still on its way.
    assert 0.3 < grown[-1] < 0.8 * 5.0 * (warmed[-1] - warmed[0])
    assert np.abs(by_hall[1].pose - by_hall[2].pose).max() < 1e-9, "the hall has not moved"
    with_it, without = change(jig_borer_lumps, "slow_structure:pedestal", inputs, **own)[1:]
    half = (with_it.pose - without.pose)[0, :, 2]
    np.testing.assert_allclose(half, 0.5 * grown, atol=1e-9)


def test_a_fixture_stands_on_what_drives_it(jig_borer_lumps):
    own = {"growth": 3.0, "minutes": 5.0, "nose_share": 1.0, "direction": 0.0}
    inputs = steady(12000.0, 6.0)
    moved, _, without = change(jig_borer_lumps, "fixture_warming:pedestal", inputs, **own)
    warmed = without.temperatures[0, :, jig_borer_lumps.node_index["pedestal"]]
    assert moved["S1"][-1] == pytest.approx(3.0 * (warmed[-1] - warmed[0]), rel=0.1)
    nose, _, _ = change(jig_borer_lumps, "fixture_warming", inputs, **own)
    assert nose["S1"][60] > 3.0 * moved["S1"][60]


def test_column_bending_follows_either_side_alone(jig_borer_lumps):
    own = {"tilt": 10.0, "hours": 2.0, "direction": 90.0, "lever": 0.0}
    step = hall_step(2.0)
    _, with_it, without = change(jig_borer_lumps, "column_bending:hall", step, **own)
    pose = (with_it.pose - without.pose)[0]
    assert pose[-1, 4] == pytest.approx(10.0 * (1.0 - np.exp(-1.0)), rel=1e-2)
    _, with_it, without = change(jig_borer_lumps, "column_bending:parts", step, **own)
    pose = (with_it.pose - without.pose)[0]
    assert 0.0 < pose[-1, 4] < 2.5, "the column itself has hardly moved"


def test_a_key_may_name_the_usual_driver(jig_borer_lumps):
    inputs = hall_step(1.0)
    usual = change(jig_borer_lumps, "slow_structure", inputs)[1]
    named = change(jig_borer_lumps, "slow_structure:hall", inputs)[1]
    np.testing.assert_array_equal(usual.pose, named.pose)


@pytest.mark.parametrize("key", ["fixture_warming:base", "slow_structure:base"])
def test_a_named_part_drives_though_calibration_makes_another_one_heavier(key):
    machine = with_effects(read_machine("lathe"), key)
    heavier = machine.with_values({"nodes.front_frame.capacity": 2e5}, beyond=True)
    assert "base" not in catalogue()[law_of(key)].drivers(heavier)
    effects = effects_in_force(heavier, Values(heavier.parameters, None))
    (effect,) = [effect for effect in effects if effect.key == key]
    assert effect._part == heavier.node_index["base"]
