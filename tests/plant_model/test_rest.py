"""Parts that start at rest: where thermometers and boundaries leave them."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest

from plant_model.effects import catalogue
from plant_model.machine import REST, Machine
from plant_model.machine_file import machine_from_table, read_machine
from plant_model.simulate import simulate, start_readings
from plant_model.stepper import PlantStepper
from tests.plant_model.drawing.by_hand import lumps, number
from tests.plant_model.drawing.pages import machine_of, small_page
from tests.refusing import refusal


def still(machine: Machine, hours: float = 2.0, **readings: float) -> pd.DataFrame:
    """Return a machine that stands: hall 24, coolant 21 degC, thermometers' readings."""
    time = np.arange(0.0, hours * 3600.0 + 30.0, 60.0)
    given = {"ambient": 24.0, "coolant_inlet": 21.0}
    columns = {entry.column: given.get(entry.name, 0.0) for entry in machine.inputs}
    read = {f"{name}_degC": value for name, value in readings.items()}
    return pd.DataFrame({"time_s": time} | columns | read)


def all_at(machine: Machine, start: str) -> Machine:
    return replace(machine, nodes=tuple(replace(node, start=start) for node in machine.nodes))


def chain() -> Machine:
    """Return the small machine with a chain beside it: T1 - 3 W/K - middle - 1 W/K - hall."""
    table = lumps()
    for name, start in (("warm", "T1"), ("middle", REST), ("alone", REST)):
        table["nodes"].append({"name": name, "capacity": number(100.0, "J/K"), "start": start})
    heat = {"kind": "steady_heat", "name": "drives", "node": "alone", "power": number(20.0, "W")}
    table["sources"].append(heat)
    table["effects"]["plain_heat"] = {}
    between = {"kind": "contact", "between": ["warm", "middle"], "conductance": number(3.0, "W/K")}
    film = {"area": number(0.1, "m2"), "coefficient": number(10.0, "W/(m2 K)")}
    to_hall = {"kind": "convection", "between": ["middle", "ambient"], **film}
    table["links"] += [between, to_hall]
    return machine_from_table(table, "chain.toml")


def test_a_part_between_two_starts_at_their_weighted_mean():
    machine = chain()
    start = simulate(machine, still(machine, T1=32.0, T2=24.0)).temperatures[0, 0]
    assert start[machine.node_index["middle"]] == pytest.approx((3 * 32.0 + 1 * 24.0) / 4, abs=1e-6)
    # What exchanges nothing stands at the hall's temperature, even if it has heat.
    assert start[machine.node_index["alone"]] == pytest.approx(24.0, abs=1e-6)


def test_only_what_no_thermometer_reads_starts_at_rest():
    machine = machine_of(small_page())
    read = {sensor.of: sensor.name for sensor in machine.sensors}
    assert {node.name: node.start for node in machine.nodes if not node.rests} == read
    start = simulate(machine, still(machine, T1=22.0, T2=23.5)).temperatures[0, 0]
    for node, value in (("housing_4_xp", 22.0), ("head", 23.5)):
        assert start[machine.node_index[node]] == value
    assert 21.0 < start[machine.node_index["jacket_one"]] < 22.0
    assert 23.5 < start[machine.node_index["column"]] < 24.0


@pytest.mark.parametrize("in_series", [False, True])
def test_a_whole_machine_at_rest_does_not_move(in_series):
    page = small_page()
    if in_series:
        (first,) = page["jackets"]
        second = first | {"name": "two", "from": 121, "after": "one"}
        page["jackets"] = [first | {"to": 120}, second]
    machine = all_at(machine_of(page), REST)
    found = simulate(machine, still(machine)).temperatures[0]
    np.testing.assert_allclose(found[-1], found[0], rtol=0.0, atol=1e-6)
    assert np.ptp(found[0]) > 2.0
    begun = all_at(machine, "ambient")
    assert np.ptp(simulate(begun, still(machine)).temperatures[0], axis=0).max() > 2.0


def test_other_numbers_start_it_elsewhere():
    machine = machine_of(small_page())
    frame = still(machine, T1=22.0, T2=23.0)
    name = "numbers.bearing_seats"
    entry = machine.parameters[name]
    given = simulate(machine, frame, {name: [entry.low, entry.high]}).temperatures[:, 0]
    assert np.abs(given[0] - given[1]).max() > 1e-3
    for value, row in zip((entry.low, entry.high), given, strict=True):
        alone = simulate(machine.with_values({name: value}), frame).temperatures[0, 0]
        np.testing.assert_allclose(row, alone, rtol=0.0, atol=1e-9)


def test_a_stepper_starts_as_a_simulation_does():
    machine = machine_of(small_page())
    frame = still(machine, T1=22.0, T2=23.0)
    stepper = PlantStepper(machine)
    first = {entry.name: float(frame[entry.column].iloc[0]) for entry in machine.inputs}
    stepper.reset(first, start_readings(machine, frame))
    for _ in range(10):
        stepper.step(60.0, first)
    read = simulate(machine, frame).readings
    for name in ("T1", "T2"):
        assert stepper.outputs()[name] == pytest.approx(read[name][0, 10], abs=1e-6)


def test_what_a_thermometer_shows_wrongly_is_not_where_a_part_starts():
    machine = read_machine("jig_borer_lumps")
    wrong = dict(catalogue()["sensor_offset"].parameters)
    wrong["error"] = replace(wrong["error"], value=3.0)
    machine = replace(machine, effects=machine.effects | {"sensor_offset:T2": wrong})
    frame = pd.DataFrame({"T2_degC": [25.0], "T3_degC": [21.0]})
    assert start_readings(machine, frame) == {"T2": 22.0, "T3": 21.0}


def test_no_thermometer_may_have_its_name():
    table = lumps()
    table["sensors"][0]["name"] = REST
    assert "'rest' is not allowed" in refusal(machine_from_table, table, "signals.toml")
