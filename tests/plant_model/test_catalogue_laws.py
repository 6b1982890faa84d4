"""Effects of the catalogue that move heat, against hand calculations and what marks them."""

from dataclasses import replace

import numpy as np
import pytest

from gap_finder.candidates import with_effect
from plant_model.effects.base import NONE
from plant_model.effects.bearing_friction import viscous_torque
from plant_model.machine import Machine
from plant_model.network import Network, effects_in_force
from plant_model.parameters import Values
from plant_model.simulate import simulate
from tests.plant_model.catalogue_machines import change, heat_of, lathe, made, steady

ALL, BY_SHAFT = "all parts", "thermal_preload:shaft_housing"
PRELOAD, IRON = {"gain": 0.2}, {"power": 400.0, "eddy_share": 0.75, "stator_share": 0.9}
CUT = {"share": 0.05, "tool_share": 0.4}
FILM, GRAY = {"film_at_10_K": 3.0}, {"emissivity": 0.5}
OF_THE_LATHE = [
    # M1 = 0.001 * 1000 * 120 = 120 N mm; times 0.2 * 10; H = 1.047e-4 * 3000 * 240 = 75.384 W.
    ("thermal_preload", PRELOAD, 3000.0, {"ring": 40.0, "race": 30.0}, {"ring": 37.692}),
    ("thermal_preload", PRELOAD, 3000.0, {"ring": 40.0, "race": 30.0}, {"race": 37.692}),
    ("thermal_preload", PRELOAD, 3000.0, {"race": 30.0}, {ALL: 0.0}),
    # 1.047e-4 * 3000 * 120 * 9 = 339.2 W is all that a seizing bearing may add.
    ("thermal_preload", PRELOAD, 3000.0, {"ring": 200.0}, {ALL: 339.228}),
    # The same, driven by quill and headstock instead of the rings.
    (BY_SHAFT, PRELOAD, 3000.0, {"quill": 40.0, "headstock": 30.0}, {"ring": 37.692}),
    (BY_SHAFT, PRELOAD, 3000.0, {"ring": 40.0}, {ALL: 0.0}),
    # At 160 K twice the 3 W/(m2 K) that the film holds: 3 * 0.8 m2 * 160 K more; at 0.625 K half.
    ("natural_convection", FILM, 0.0, {"headstock": 180.0}, {"headstock": -384.0}),
    ("natural_convection", FILM, 0.0, {"headstock": -140.0}, {"headstock": 384.0}),
    ("natural_convection", FILM, 0.0, {"headstock": 20.625}, {"headstock": 0.75}),
    # 5.670374419e-8 * 0.5 * 0.8 m2 * (353.15^4 - 293.15^4), less 4 * 293.15^3 * 60 K of it.
    ("radiation", GRAY, 0.0, {"headstock": 80.0}, {"headstock": -48.1410}),
    # Half speed: 400 * (0.25 / 2 + 0.75 / 4) = 125 W.
    ("motor_iron_loss", IRON, 2000.0, {}, {"winding": 112.5, "cage": 12.5}),
    ("motor_iron_loss", IRON, 4000.0, {}, {ALL: 400.0}),
    ("windage", {"power": 160.0}, 4000.0, {}, {"cage": 80.0, "winding": 80.0}),
    # 60 W/K * ((1 + 0.1 * 5)^0.95 - 1) * 5 K; opening, the resistance grows by as much.
    ("joint_resistance", {"gain": 0.1}, 0.0, {"race": 25.0}, {"headstock": 140.9689, "ring": 0.0}),
    ("joint_resistance", {"gain": 0.1}, 0.0, {"race": 25.0}, {"race": -140.9689}),
    ("joint_resistance", {"gain": -0.1}, 0.0, {"race": 25.0}, {"headstock": -95.9040}),
    # No looser than a fifth of the pressure, however hot.
    ("joint_resistance", {"gain": -0.3}, 0.0, {"race": 120.0}, {"headstock": -4699.442}),
]
# Area times radius cubed: 0.057 * 50^3 of 0.057 * 50^3 + 4 * 0.008 * 36^3 + 0.025 * 33^3.
GAP = 7125.0 / (7125.0 + 1492.992 + 898.425)
OF_THE_JIG_BORER = [
    ("windage", {"power": 160.0}, 20000.0, 0.0, {}, {ALL: 160.0, "rotor": 80.0 * GAP}),
    ("windage", {"power": 160.0}, 10000.0, 0.0, {}, {ALL: 20.0, "stator": 10.0 * GAP}),
    # The highest torque is 200 N m, so 20 N m is the reference; at 275 degC copper has doubled.
    ("copper_loss", {"power": 100.0}, 0.0, -20.0, {}, {"stator": 100.0}),
    ("copper_loss", {"power": 100.0}, 0.0, 10.0, {}, {"stator": 25.0}),
    ("copper_loss", {"power": 100.0}, 0.0, 20.0, {"stator": 275.0}, {"stator": 200.0}),
    # 10 N m at 6000 r/min is 6283.2 W; 5 % of it 314.16 W.
    ("cutting_heat", CUT, 6000.0, 10.0, {}, {"test_bar": 125.6637, "shaft_front": 188.4956}),
    ("cutting_heat", CUT, 6000.0, 0.0, {}, {ALL: 0.0}),
]


def assert_hand_calculated(heat: dict[str, float], watts: dict[str, float]) -> None:
    found = heat | {ALL: sum(heat.values())}
    assert {node: found[node] for node in watts} == pytest.approx(watts, rel=1e-5, abs=1e-12)


@pytest.mark.parametrize(("name", "own", "speed", "temperatures", "watts"), OF_THE_LATHE)
def test_a_law_gives_the_heat_of_a_hand_calculation(name, own, speed, temperatures, watts):
    assert_hand_calculated(heat_of(made(lathe(), name, **own)[1], speed, temperatures), watts)


@pytest.mark.parametrize(
    ("name", "own", "speed", "torque", "temperatures", "watts"), OF_THE_JIG_BORER
)
def test_a_law_of_gaps_and_torque_gives_the_heat_of_a_hand_calculation(
    name, own, speed, torque, temperatures, watts, jig_borer_lumps
):
    _, effect = made(jig_borer_lumps, name, **own)
    assert_hand_calculated(heat_of(effect, speed, temperatures, torque=torque), watts)


def test_friction_speed_exponent_turns_about_half_the_highest_speed(jig_borer_lumps):
    _, effect = made(jig_borer_lumps, "friction_speed_exponent", deviation=0.5)
    item = jig_borer_lumps.of_kind("sources", "bearing")[0]
    numbers = {key: np.array([p.value]) for key, p in item.parameters.items()}
    torque = viscous_torque(
        numbers["f0"], numbers["viscosity"], np.array([5000.0]), numbers["mean_diameter"]
    )
    load = numbers["f1"] * numbers["preload"] * numbers["mean_diameter"]
    palmgren = 1.047e-4 * 5000.0 * 2.0 * (torque + load)[0]
    assert heat_of(effect, 10000.0)["front_inner"] == pytest.approx(0.0, abs=1e-9)
    slow = heat_of(effect, 5000.0)
    expected = palmgren * (0.5**0.5 - 1.0)
    assert slow["front_inner"] + slow["front_outer"] == pytest.approx(expected, rel=1e-9)
    assert sum(heat_of(effect, 0.0).values()) == 0.0


def test_forced_convection_grows_with_speed_and_vanishes_at_stop(jig_borer_lumps):
    _, effect = made(jig_borer_lumps, "forced_convection", gain=2.0)

    def added(speed: float) -> dict[str, float]:
        pairs = effect.conductance({"speed": np.array([speed])}, NONE, NONE)
        return {jig_borer_lumps.nodes[e.node].name: float(e.conductance[0, 0]) for e in pairs}

    # 0.06 m2 * 9 W/(m2 K) * 2 * (10000 / 20000)^0.7.
    assert added(10000.0)["housing_rear"] == pytest.approx(0.06 * 9.0 * 2.0 * 0.5**0.7)
    assert set(added(0.0).values()) == {0.0}
    assert "column" not in added(20000.0), "the spindle does not stir the air around the column"
    moved, *_ = change(jig_borer_lumps, "forced_convection", steady(0.0, 1.0, hall=25.0))
    assert max(np.abs(series).max() for series in moved.values()) < 1e-9


@pytest.mark.parametrize(
    ("name", "own", "warmer"),
    [("radiation", {"emissivity": 0.9}, 0.01), ("natural_convection", {"film_at_10_K": 6.0}, 10.0)],
)
def test_what_a_film_holds_is_not_counted_twice(name, own, warmer):
    machine = lathe()
    at_reference = {node.name: 20.0 + warmer for node in machine.nodes}
    _, effect = made(machine, name, **own)
    heat = heat_of(effect, 0.0, at_reference)
    assert max(map(abs, heat.values())) < 1e-3 * 3.0 * 8.0 * warmer, "of what the film gives off"
    # A film of 2 W/(m2 K) holds no more than that: the rest of the law is all there.
    films = [name for name in machine.parameters if name.endswith("hall.coefficient")]
    thin = machine.with_values(dict.fromkeys(films, 2.0), beyond=True)
    _, effect = made(thin, name, **own)
    law = {"radiation": 4.0 * 0.9 * 5.670374419e-8 * 293.15**3, "natural_convection": 6.0}[name]
    heat = heat_of(effect, 0.0, at_reference)
    assert heat["headstock"] == pytest.approx(-0.8 * warmer * (law - 2.0), rel=1e-3)


def test_bearing_run_in_counts_turning_hours_only(jig_borer_lumps):
    _, effect = made(jig_borer_lumps, "bearing_run_in", excess=1.0, hours=2.0)
    inputs = steady(0.0, 6.0)
    turning = inputs["time_s"] >= 3 * 3600.0
    inputs["speed_rpm"] = np.where(turning, 9000.0, 0.0)
    moved, with_it, without = change(
        jig_borer_lumps, "bearing_run_in", inputs, excess=1.0, hours=2.0
    )
    assert np.abs(moved["T1"][~turning]).max() < 1e-9
    peak = np.argmax(moved["T1"])
    assert inputs["time_s"][peak] < 4.0 * 3600.0
    assert moved["T1"][-1] < 0.5 * moved["T1"][peak], "it is gone with the hours"
    fresh, later = heat_of(effect, 9000.0, states=[0.0]), heat_of(effect, 9000.0, states=[2.0])
    assert later["rear_outer"] / fresh["rear_outer"] == pytest.approx(np.exp(-1.0))
    assert with_it.temperatures.shape == without.temperatures.shape


def test_bearings_that_turned_before_have_run_in_by_as_much(jig_borer_lumps):
    whole = steady(9000.0, 4.0)
    own = {"excess": 1.0, "hours": 2.0}
    _, first, _ = change(jig_borer_lumps, "bearing_run_in", whole, **own)
    machine, effect = made(jig_borer_lumps, "bearing_run_in", before=4.0, **own)
    start = effect.start_states(np.zeros((1, len(machine.nodes))), {})
    assert start.tolist() == [[4.0]]
    _, second, without = change(jig_borer_lumps, "bearing_run_in", whole, before=4.0, **own)
    front = jig_borer_lumps.node_index["front_inner"]
    excess = [(one.temperatures - without.temperatures)[0, 20, front] for one in (first, second)]
    assert excess[1] == pytest.approx(excess[0] * np.exp(-2.0), rel=0.05)


def test_coolant_thermostat_swings_with_its_band_and_period(jig_borer_lumps):
    inputs = steady(0.0, 3.0)
    moved, *_ = change(jig_borer_lumps, "coolant_thermostat", inputs, band=1.0, period=20.0)
    late = inputs["time_s"] > 3600.0
    # A jacket follows within a minute or so, walls included, so it shows a little less than 1 K.
    assert 0.4 < moved["T3"][late].max() < 1.05
    assert moved["T3"][late].min() == pytest.approx(-moved["T3"][late].max(), abs=0.15)
    series = moved["T3"][late]
    rising = np.flatnonzero((series[:-1] < 0.0) & (series[1:] >= 0.0))
    assert np.diff(rising).mean() == pytest.approx(20.0, rel=0.05)
    _, effect = made(jig_borer_lumps, "coolant_thermostat", band=1.0)
    swing = heat_of(effect, 0.0, states=[0.375])["jacket_front"]
    assert swing == pytest.approx(0.5 * 3.0 / 60.0 * 3700.0)


def test_coolant_thermostat_begins_where_its_phase_says(jig_borer_lumps):
    inputs = steady(0.0, 1.0)
    first = change(jig_borer_lumps, "coolant_thermostat", inputs, phase=0.0)[0]["T3"]
    other = change(jig_borer_lumps, "coolant_thermostat", inputs, phase=0.5)[0]["T3"]
    np.testing.assert_allclose(first, -other, atol=2e-2)
    assert first[2] < -0.1, "phase 0 is the coldest instant"


def switched(machine: Machine, part: str, **values: float) -> Machine:
    """Return a machine whose cooling a part switches."""
    return with_effect(machine, f"coolant_thermostat:{part}", values)


def test_a_part_switches_the_cooling_within_its_dead_band(jig_borer_lumps):
    inputs = steady(9000.0, 4.0)
    machine = switched(jig_borer_lumps, "rear_outer", band=1.5, on_above=25.0, dead_band=2.0)
    series = simulate(machine, inputs).temperatures[0, :, machine.node_index["rear_outer"]]
    settled = series[inputs["time_s"] > 3600.0]
    free = simulate(jig_borer_lumps, inputs).temperatures[0, -1, machine.node_index["rear_outer"]]
    assert free > 25.5, "it cools all the time"
    # Rests until the part reaches 25 degC for the first time, then never again: too hot to rest.
    assert settled.min() > 23.0
    assert settled[-1] == pytest.approx(free, abs=0.3)
    slower = simulate(machine, steady(4000.0, 4.0)).temperatures[0]
    part = slower[:, machine.node_index["rear_outer"]][inputs["time_s"] > 3600.0]
    turns = np.flatnonzero(np.diff(np.sign(np.diff(part))) != 0)
    assert len(turns) > 6, "it comes and goes"
    assert part.max() == pytest.approx(25.0, abs=0.3)
    assert part.min() == pytest.approx(23.0, abs=0.3)


def test_cooling_that_rests_for_good_is_a_flow_that_stops(jig_borer_lumps):
    inputs = steady(3000.0, 2.0)
    never = switched(jig_borer_lumps, "rear_outer", band=15.0, on_above=190.0)
    still = tuple(item for item in jig_borer_lumps.items if item.kind != "coolant_flow")
    without = simulate(replace(jig_borer_lumps, items=still), inputs).temperatures[0, -1]
    closely = simulate(never, inputs, tolerance=1e-4).temperatures[0, -1]
    np.testing.assert_allclose(closely, without, atol=0.001)
    np.testing.assert_allclose(simulate(never, inputs).temperatures[0, -1], without, atol=0.03)
    little = switched(jig_borer_lumps, "rear_outer", band=0.2, on_above=190.0)
    cool = simulate(little, inputs).temperatures[0, -1]
    plain = simulate(jig_borer_lumps, inputs).temperatures[0, -1]
    jacket = jig_borer_lumps.node_index["jacket_front"]
    assert 0.1 < cool[jacket] - plain[jacket] < 0.5


@pytest.mark.long
def test_coolant_degradation_ends_as_a_machine_of_less_flow_and_weaker_walls(jig_borer_lumps):
    inputs = steady(9000.0, 20.0)
    less = {
        item.parameter_name("flow"): 0.75 * item.parameters["flow"].value
        for item in jig_borer_lumps.of_kind("links", "coolant_flow")
    } | {
        item.parameter_name(key): 0.75**0.8 * parameter.value
        for item in jig_borer_lumps.of_kind("links", "coolant_wall", "coolant_unevenness")
        for key, parameter in item.parameters.items()
    }
    # A jacket that works at half is worse by the same share.
    half = {"effects.coolant_jacket.scale": 0.5}
    jig_borer_lumps = jig_borer_lumps.with_values(half)
    weaker = simulate(jig_borer_lumps.with_values(less), inputs)
    moved, with_it, _ = change(jig_borer_lumps, "coolant_degradation", inputs, loss=0.25, hours=2.0)
    np.testing.assert_allclose(with_it.temperatures[0, -1], weaker.temperatures[0, -1], atol=0.05)
    assert moved["T1"][-1] > 0.3
    assert abs(moved["T1"][5]) < 0.1 * moved["T1"][-1], "at first the jackets are sound"


def conductance_between(machine: Machine, one: str, other: str, **values: float) -> float:
    given = Values(machine.parameters, {f"effects.{k}.scale": v for k, v in values.items()})
    inputs = {entry.name: np.array([0.0]) for entry in machine.inputs}
    matrix, _ = Network(machine, given, effects_in_force(machine, given)).conductances(inputs)
    return -float(matrix[0, machine.node_index[one], machine.node_index[other]])


def test_without_jackets_no_side_is_cooled(jig_borer_lumps):
    sides = ("housing_front_xp", "housing_front_xm")
    wall, more = (
        jig_borer_lumps.parameters[f"links.{name}"].value
        for name in ("housing_front_xp-jacket_front.conductance", "unevenness_front_xp.difference")
    )
    usual = [conductance_between(jig_borer_lumps, side, "jacket_front") for side in sides]
    assert usual == pytest.approx([wall + more, wall - more])
    off = [
        conductance_between(jig_borer_lumps, side, "jacket_front", coolant_jacket=0.0)
        for side in sides
    ]
    assert off == [0.0, 0.0]


def test_one_side_of_a_jacket_gains_at_most_what_the_other_can_lose(jig_borer_lumps):
    wall = jig_borer_lumps.parameters["links.housing_front_xp-jacket_front.conductance"].value
    over = {"effects.uneven_cooling.scale": 1.5} | {
        f"links.unevenness_front_{side}.difference": share * 33.8
        for side, share in (("xp", 1.0), ("xm", -1.0))
    }
    most = jig_borer_lumps.with_values(over)
    sides = ("housing_front_xp", "housing_front_xm")
    cooled = [conductance_between(most, side, "jacket_front") for side in sides]
    assert wall < 1.5 * 33.8
    assert cooled == pytest.approx([2.0 * wall, 0.0])


def test_coolant_supply_offset_is_coolant_of_another_temperature(jig_borer_lumps):
    inputs = steady(6000.0, 3.0)
    warmer = simulate(jig_borer_lumps, inputs.assign(T9_degC=inputs["T9_degC"] + 0.7))
    moved, with_it, _ = change(jig_borer_lumps, "coolant_supply_offset", inputs, offset=0.7)
    np.testing.assert_allclose(with_it.temperatures, warmer.temperatures, atol=1e-9)
    assert np.all(moved["T9"] == 0.0)
