"""The expanded machine: equal to one written by hand, closed in energy, settled in its cells."""

from functools import cache

import numpy as np
import pandas as pd
import pytest

from plant_model.convergence import convergence
from plant_model.drawing.layout import Drawing
from plant_model.drawing.mesh import Mesh
from plant_model.machine import Machine
from plant_model.machine_file import machine_from_table, read_machine
from plant_model.machine_writer import write_machine
from plant_model.parameters import ParameterError
from plant_model.simulate import Simulation, simulate
from plant_model.warm_up import warm_up
from tests.plant_model.conftest import with_effects
from tests.plant_model.drawing.by_hand import lumps
from tests.plant_model.drawing.pages import (
    changed,
    machine_of,
    shipped_page,
    small_page,
    without_one_sidedness,
)
from tests.refusing import refusal

WARM = 240
"""Row of the warm-up at which the spindle is stopped."""


def driven(hours: float = 4.0) -> pd.DataFrame:
    """Return speed steps, a swinging hall and a warming coolant."""
    time = np.arange(0.0, hours * 3600.0 + 30.0, 60.0)
    return pd.DataFrame(
        {
            "time_s": time,
            "speed_rpm": np.where(time % 5400.0 < 3600.0, 9000.0, 2000.0),
            "hall_degC": 20.0 + np.sin(time / 2000.0),
            "inlet_degC": 20.0 + 1.5 * (1.0 - np.exp(-time / 5400.0)),
        }
    )


def test_equal_to_the_same_machine_by_hand_in_lumps():
    ours = machine_of(small_page())
    theirs = machine_from_table(lumps(), "by_hand.toml")
    assert {node.name for node in ours.nodes} == {node.name for node in theirs.nodes}
    order = [ours.node_index[node.name] for node in theirs.nodes]
    drawn, by_hand = (simulate(machine, driven()) for machine in (ours, theirs))
    np.testing.assert_allclose(
        drawn.temperatures[..., order], by_hand.temperatures, rtol=0.0, atol=1e-9
    )
    np.testing.assert_allclose(drawn.pose, by_hand.pose, rtol=0.0, atol=1e-9)
    for name, reading in by_hand.readings.items():
        np.testing.assert_allclose(drawn.readings[name], reading, rtol=0.0, atol=1e-9)
    # And not because nothing happens.
    assert np.abs(by_hand.pose).max(axis=(0, 1)).min() > 0.0
    assert np.ptp(by_hand.temperatures[0, :, theirs.node_index["front_inner"]]) > 10.0


def test_half_and_double_the_cells():
    half, usual, double, *_ = convergence("jig_borer")
    assert (half.longest_mm, double.longest_mm) == (2 * usual.longest_mm, usual.longest_mm / 2)
    assert half.nodes < usual.nodes < double.nodes
    assert {half.sectors, usual.sectors, double.sectors} == {4}
    assert usual.drift < 0.02
    assert usual.temperature < 0.03
    assert double.drift < 0.02


def test_the_page_of_the_jig_borer_measures_what_its_lumps_measure(jig_borer_lumps):
    page = read_machine("jig_borer")
    assert [s.name for s in page.sensors] == [s.name for s in jig_borer_lumps.sensors]
    assert page.inputs == jig_borer_lumps.inputs
    assert {k: v for k, v in page.rig.items() if "um" not in k} == {
        k: v for k, v in jig_borer_lumps.rig.items() if "um" not in k
    }


def test_a_thermometer_reads_its_place():
    """A rod warm at one end: what is read lies on the course along it, wherever the cells are."""
    read = {}
    places = (20.0, 110.0, 180.0)
    for at in places:
        for longest in (10.0, 40.0):
            page = changed(small_page(), "thermometers.0.at", at)
            machine = machine_of(changed(page, "cells.longest", longest))
            found = simulate(machine, warm_up(machine))
            read[at, longest] = float(found.readings["T1"][0, WARM])
    for at in places:
        assert read[at, 40.0] == pytest.approx(read[at, 10.0], abs=0.3)
    spread = [read[at, 10.0] for at in places]
    assert max(spread) - min(spread) > 1.0


def test_one_sidedness_does_not_depend_on_the_sectors():
    tilts = []
    for sectors in (4, 8, 16):
        machine = machine_of(small_page(), sectors=sectors)
        tilts.append(simulate(machine, warm_up(machine)).pose[0, WARM, 3])
    assert abs(tilts[0]) > 1.0
    np.testing.assert_allclose(tilts, tilts[-1], rtol=0.03)
    np.testing.assert_allclose(tilts[1:], tilts[-1], rtol=0.001)
    even = machine_of(small_page(), sectors=1)
    assert simulate(even, warm_up(even)).pose[0, WARM, 3] == 0.0


def test_still_air_in_a_gap_conducts_as_a_hollow_cylinder():
    machine = machine_of(small_page())
    wide = [item for item in machine.of_kind("links", "air_gap") if "rotor" not in item.name]
    assert wide
    for item in wide:
        area, radius, gap = (item.parameters[key].value for key in ("area", "radius", "gap"))
        length = area * 1e3 / (2 * np.pi * radius)
        # Per watt and kelvin of air; shaft of 60 mm, gap of 15 mm.
        exact = 2 * np.pi * length / np.log(45 / 30)
        assert gap == 15.0
        assert area / (gap * 1e-3) == pytest.approx(exact, rel=0.015)


def test_a_pulley_has_the_film_of_its_own_surface_and_covers_the_shafts():
    machine = read_machine("belt_spindle")
    film = machine.parameters["numbers.nose_film_at_rest"].value
    areas: dict[str, float] = {}
    for item in machine.of_kind("links", "contact"):
        node, other = item.refs["between"]
        if other == "enclosure_air" and node.startswith(("shaft", "pulley")):
            areas[node] = item.parameters["conductance"].value / film
    # A pulley of 120 mm over 60 mm; of 100 mm of shaft behind the housing, 65 mm thick, 40 mm stay
    # free, and 40 mm of 100 mm in front.
    assert areas.pop("pulley") == pytest.approx(np.pi * 0.120 * 0.060)
    assert sum(areas.values()) == pytest.approx(np.pi * (0.065 * 0.040 + 0.100 * 0.040))


def test_a_bearing_warmer_on_one_side_tilts_alike_in_all_sectors():
    page = without_one_sidedness()
    tilts = []
    for sectors, degrees in ((4, 0.0), (8, 0.0), (8, 30.0), (16, 90.0)):
        machine = with_effects(machine_of(page, sectors=sectors), "uneven_bearing_heating")
        machine = machine.with_values({"effects.uneven_bearing_heating.direction": degrees})
        found = simulate(machine, warm_up(machine))
        # The ring's own tilt, without that of the housing: 11.5 urad/K, 0.8 and 1.5 K.
        ring = 11.5 * 0.8 * 1.5 * found.states[0, WARM, 0]
        plain = simulate(machine_of(page, sectors=sectors), warm_up(machine))
        tilt = (found.pose - plain.pose)[0, WARM, 3:5]
        tilts.append(np.hypot(*tilt) - ring)
    assert tilts[0] > 3.0
    np.testing.assert_allclose(tilts, tilts[-1], rtol=0.03)


@pytest.mark.parametrize(
    ("side", "sectors"), [("Y+", 4), (270, 4), (45, 8), (60, 12), (22.5, 16), (13, 8)]
)
def test_as_few_sectors_as_thermometers_allow(side, sectors):
    page = small_page()
    del page["cells"]["sectors"]
    page["thermometers"][0]["side"] = side
    assert Mesh(Drawing(page, "page.toml")).sectors == sectors
    page["cells"]["sectors"] = 16
    assert Mesh(Drawing(page, "page.toml")).sectors == 16


def test_a_calibrated_page_is_written_in_lumps(tmp_path):
    machine = read_machine("belt_spindle")
    moved = machine.with_values({"numbers.balls": 15.0, "sources.front.preload": 300.0})
    path = write_machine(moved, "belt_spindle", tmp_path / "after.toml")
    again = read_machine(path)
    assert again == moved
    assert path.read_text(encoding="utf-8").startswith("# Expanded from the page belt_spindle.toml")
    with pytest.raises(ParameterError, match=r"follows numbers\.balls"):
        again.with_values({"links.front_inner-front_outer.conductance": 30.0})


def at_full_speed(machine: Machine) -> tuple[Simulation, dict[str, float]]:
    found = simulate(machine, warm_up(machine))
    nodes = dict(zip(machine.node_index, found.temperatures[0, WARM], strict=True))
    return found, {name: float(value) for name, value in nodes.items()}


@cache
def as_drawn() -> tuple[Simulation, dict[str, float]]:
    return at_full_speed(machine_of(small_page()))


@pytest.mark.parametrize(
    ("key", "value", "node", "sign"),
    [
        ("bearings.0.f0", 1.5, "front_inner", 1),
        ("bearings.0.f1", 0.002, "front_inner", 1),
        ("bearings.0.grade", 68, "front_inner", 1),
        ("bearings.0.running_temperature", 70, "front_inner", -1),
        ("bearings.0.viscosity_index", 150, "front_inner", 1),
        ("bearings.0.conductance", 60, "front_inner", -1),
        ("bearings.0.lubrication", "oil", "front_inner", 1),
        ("bearings.0.seat", 1000, "front_inner", 1),
        ("bearings.1.seat", 50000, "rear_outer", -1),
        ("bearings.0.sleeve", {"from": 90, "to": 200}, "front_outer", -1),
        ("motor.rotor_share", 0.6, "rotor", 1),
        ("motor.joint", 500, "rotor", 1),
        ("motor.gap", 3.0, "rotor", 1),
        ("jackets.0.fluid", "oil 32", "front_outer", 1),
        ("jackets.0.wall", 20, "front_outer", 1),
        ("jackets.0.channel", {"width": 15, "depth": 12}, "front_outer", 1),
        ("jackets.0.inlet_side", "X-", "housing_4_xp", 1),
        ("carriers.0.joint", 5, "rear_outer", 1),
        ("tool.joint", 4, "tool", 1),
        ("shaft.material", "invar", "shaft_6", -1),
        ("housing.material", "aluminium", "front_outer", -1),
        ("housing.stretches.0.outer", 260, "front_outer", 1),
        ("shaft.stretches.0.inner", 50, "shaft_6", -1),
    ],
)
def test_every_number_that_has_a_usual_value_moves_what_it_should(key, value, node, sign):
    before = as_drawn()[1][node]
    after = at_full_speed(machine_of(changed(small_page(), key, value)))[1][node]
    assert sign * (after - before) > 0.002


@pytest.mark.parametrize(
    ("key", "value", "axis", "sign"),
    [
        ("carriers.0.grows", {"y": 200, "z": 300}, 2, 1),
        ("carriers.0.grows", {"x": 300, "y": 200}, 0, 1),
        ("carriers.0.bends.0.pitch", -1, 4, -1),
        ("shaft.material", "invar", 2, -1),
        ("jackets.0.inlet_side", "X-", 3, -1),
        ("jackets.0.inlet_side", "Y-", 4, -1),
        ("tool.material", "carbide", 5, -1),
    ],
)
def test_every_length_moves_the_nose_the_right_way(key, value, axis, sign):
    before = as_drawn()[0].pose[0, WARM, axis]
    after = at_full_speed(machine_of(changed(small_page(), key, value)))[0].pose[0, WARM, axis]
    assert sign * (after - before) > 1e-3


@pytest.mark.parametrize(
    ("length", "name", "ends"),
    [
        (-200.0, "length", (150.0, 250.0)),
        ({"value": -200.0, "low": -300.0, "high": -180.0}, "length", (180.0, 300.0)),
        ({"value": -200.0, "low": -400.0, "high": 100.0}, "y", (-1.0, 0.25)),
    ],
)
def test_how_far_a_carrier_moves_the_nose_is_calibrated(length, name, ends):
    plain = machine_of(changed(small_page(), "carriers.0.grows", {"y": -200.0}))
    machine = machine_of(changed(small_page(), "carriers.0.grows", {"y": length}))
    there, as_before = (at_full_speed(one)[0].pose[0, WARM, 1] for one in (machine, plain))
    assert there == pytest.approx(as_before)
    free = machine.parameters[f"structure.head_y.{name}"]
    assert free.calibrate
    assert (free.low, free.high) == pytest.approx(ends)
    held = changed(small_page(), "carriers.0.grows", {"y": {"value": -200.0, "calibrate": False}})
    assert not machine_of(held).parameters["structure.head_y.length"].calibrate


def test_every_jacket_has_the_range_that_the_page_gives_its_flow():
    page = small_page()
    page["jackets"].append(page["jackets"][0] | {"name": "two", "from": 0, "to": 50})
    flow = {"value": 8.0, "low": 7.6, "high": 8.8, "calibrate": False}
    parameters = machine_of(changed(page, "jackets.1.flow", flow)).parameters
    own = parameters["numbers.jacket_two_flow"]
    assert (own.low, own.high, own.calibrate) == (pytest.approx(0.95), pytest.approx(1.1), False)
    common = parameters["numbers.coolant_flow"]
    assert (common.low, common.high, common.calibrate) == (0.85, 1.15, True)


def test_a_designation_gives_the_bearings_sizes():
    parameters = machine_of(changed(small_page(), "bearings.1.designation", "NN3012")).parameters
    assert parameters["sources.front.mean_diameter"].value == 77.5
    assert parameters["sources.rear.mean_diameter"].value == 77.5
    assert parameters["sources.rear.f0"].value > parameters["sources.front.f0"].value
    heat = [parameters[f"nodes.{name}_inner.capacity"].value for name in ("front", "rear")]
    # Two of 18 mm width against one of 26 mm, which is fuller of metal.
    assert heat[0] / heat[1] == pytest.approx(2 * 18 * 0.68 / (26 * 0.77))


def test_a_plate_gives_the_motors_loss():
    page = changed(small_page(), "motor.loss", None)
    page["motor"] |= {"power": 15, "efficiency": 0.9, "rated_speed": 10000}
    loss = machine_of(page).parameters["sources.motor.loss"]
    # 15 kW (1 / 0.9 - 1) = 1667 W at 10,000 r/min, of which an idling motor has 20 to 70 %.
    assert loss.value == pytest.approx(0.4 * 166.67, rel=1e-3)
    assert (loss.low, loss.high) == pytest.approx((0.2 * 166.67, 0.7 * 166.67), rel=1e-3)


def test_what_stands_in_the_enclosure_warms_it():
    machine = read_machine("belt_spindle")
    nodes = at_full_speed(machine)[1]
    assert nodes["enclosure_air"] > 21.0
    page = shipped_page("belt_spindle")
    page["enclosure"]["wall"] = 40
    assert at_full_speed(machine_of(page))[1]["enclosure_air"] < nodes["enclosure_air"]


def test_a_feed_axis_warms_its_nut():
    page = shipped_page("belt_spindle")
    warm = at_full_speed(machine_of(page))[1]["z_nut"]
    page["carriers"][2]["feed"] = {"input": "feed_z", "loss": 50}
    assert at_full_speed(machine_of(page))[1]["z_nut"] > warm + 1.0


def test_lumps_have_no_cells_to_count():
    assert "is in lumps: only a page" in refusal(convergence, "jig_borer_lumps")
