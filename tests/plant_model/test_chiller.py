"""A chiller that a part's temperature switches."""

from typing import Any

import numpy as np
import pandas as pd
import pytest
from scipy.linalg import expm

from plant_model.effects.chiller import Chiller
from plant_model.machine import Machine
from plant_model.machine_file import machine_from_table
from plant_model.native.equations import equations_of
from plant_model.parameters import Values
from plant_model.simulate import simulate
from tests.plant_model.catalogue_machines import bare_table, item, link, number
from tests.refusing import refusal

POWER, CAPACITY, LOSS, HEAT = 900.0, 60e3, 6.0, 400.0
ON_ABOVE, BAND = 26.0, 2.0


def table_of(chillers: int = 1) -> dict[str, Any]:
    """Return a body heated by 400 W, its jacket, and a tank that a chiller cools."""
    carried = {"flow": (6.0, "l/min"), "heat_capacity": (3700.0, "J/(l K)")}
    watched = {"cools": "tank", "watches": "body"}
    band = {"power": (POWER, "W"), "on_above": (ON_ABOVE, "degC"), "dead_band": (BAND, "K")}
    laws = "coolant_jacket surface_convection plain_heat chiller"
    return bare_table() | {
        "name": "chilled",
        "nodes": [
            {"name": name, "capacity": number(value, "J/K"), "start": "hall"}
            for name, value in {"body": 30e3, "jacket": 2e3, "tank": CAPACITY}.items()
        ],
        "links": [
            link("coolant_flow", "jacket", "tank", **carried),
            link("coolant_flow", "tank", "jacket", **carried),
            link("coolant_wall", "body", "jacket", conductance=(150.0, "W/K")),
            link("convection", "tank", "hall", area=(1.0, "m2"), coefficient=(LOSS, "W/(m2 K)")),
        ],
        "sources": [
            {"kind": "steady_heat", "node": "body", "power": number(HEAT, "W")},
            *(item("chiller", f"chiller_{i}", watched, **band) for i in range(chillers)),
        ],
        "sensors": [{"name": "T1", "of": "body"}, {"name": "T9", "of": "tank"}],
        "rig": {"kind": "direct", "axes": {"disp_z": {"axis": "Z"}}},
        "effects": {law: {} for law in laws.split()},
    }


@pytest.fixture(scope="module")
def chilled() -> Machine:
    return machine_from_table(table_of(), "chilled.toml")


def inputs(hours: float, every_s: float = 10.0) -> pd.DataFrame:
    time = np.arange(0.0, 3600.0 * hours + 1.0, every_s)
    return pd.DataFrame({"time_s": time, "speed_rpm": 0.0, "hall_degC": 21.0})


def two_point(duration_s: float, h: float = 0.5) -> tuple[np.ndarray, np.ndarray]:
    """Return body and tank of the same loop by small Euler steps and an if."""
    body = jacket = tank = 21.0
    runs, found = False, []
    carried = 6.0 / 60.0 * 3700.0
    for _ in range(round(duration_s / h)):
        found.append((body, tank))
        runs = body > ON_ABOVE or (runs and body > ON_ABOVE - BAND)
        wall = 150.0 * (body - jacket)
        in_body, in_jacket = HEAT - wall, wall + carried * (tank - jacket)
        in_tank = carried * (jacket - tank) - LOSS * (tank - 21.0) - POWER * runs
        body += h * in_body / 30e3
        jacket += h * in_jacket / 2e3
        tank += h * in_tank / CAPACITY
    bodies, tanks = np.array(found).T
    return bodies, tanks


def periods(time_s: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Return the times between the instants at which a swing goes up through its middle [s]."""
    middle = 0.5 * (values.min() + values.max())
    up = np.flatnonzero((values[:-1] < middle) & (values[1:] >= middle))
    return np.diff(time_s[up])


def test_swings_as_a_two_point_loop_does(chilled):
    found = simulate(chilled, inputs(8.0))
    late = found.time_s > 4.0 * 3600.0
    body, tank = found.readings["T1"][0], found.readings["T9"][0]
    expected_body, expected_tank = two_point(8.0 * 3600.0)
    time = 0.5 * np.arange(len(expected_body))
    settled = time > 4.0 * 3600.0
    for shown, expected in ((body, expected_body), (tank, expected_tank)):
        # It switches once in 10 s here, in which the body warms by some 0.1 K.
        assert shown[late].max() == pytest.approx(expected[settled].max(), abs=0.25)
        assert shown[late].min() == pytest.approx(expected[settled].min(), abs=0.25)
    mean = np.mean(periods(time[settled], expected_tank[settled]))
    assert np.mean(periods(found.time_s[late], tank[late])) == pytest.approx(mean, rel=0.1)


def test_coolant_that_goes_round_is_stepped_exactly():
    found = simulate(machine_from_table(table_of(0), "circuit.toml"), inputs(2.0))
    carried = 6.0 / 60.0 * 3700.0
    per_kelvin = np.array(
        [
            [-150.0, 150.0, 0.0, HEAT],
            [150.0, -150.0 - carried, carried, 0.0],
            [0.0, carried, -carried - LOSS, 0.0],
            [0.0, 0.0, 0.0, 0.0],
        ]
    )
    rates = per_kelvin / np.array([[30e3], [2e3], [CAPACITY], [1.0]])
    rise = expm(rates * 7200.0) @ [0.0, 0.0, 0.0, 1.0]
    shown = [found.readings[name][0, -1] - 21.0 for name in ("T1", "T9")]
    np.testing.assert_allclose(shown, rise[[0, 2]], rtol=1e-9)


def test_rests_until_the_part_is_too_warm_and_then_takes_its_power(chilled):
    effect = Chiller(chilled, Values(chilled.parameters))
    cold, warm = (np.full((1, 3), value) for value in (ON_ABOVE - 0.1, ON_ABOVE + 0.1))
    out = np.zeros((1, 1, 3))
    for start, power in ((cold, 0.0), (warm, POWER)):
        states = effect.start_states(start, {})[:, None, :]
        out[:] = 0.0
        effect.heat({}, start[:, None, :], states, out)
        np.testing.assert_allclose(out[0, 0], [0.0, 0.0, -power])


def test_two_chillers_are_refused():
    assert "only one chiller" in refusal(machine_from_table, table_of(2), "chilled.toml")


def test_has_a_form_in_c(chilled):
    assert equations_of(chilled, []).settling == [0]
