"""Items that say no more than that there is heat, or more exchange in motion."""

import numpy as np
import pytest

from gap_finder.kinds.conductance_with_motion import ConductanceWithMotion
from gap_finder.kinds.heat_source import HeatSource
from plant_model.drive import drive_from
from plant_model.machine import Machine
from plant_model.native.equations import equations_of
from plant_model.network import Network, effects_in_force
from plant_model.parameters import Values
from plant_model.simulate import simulate
from plant_model.trajectory import trajectories
from tests.plant_model.conftest import inputs_over


def network_of(machine: Machine) -> Network:
    values = Values(machine.parameters)
    return Network(machine, values, effects_in_force(machine, values))


@pytest.mark.parametrize(("exponent", "share"), [(1.0, 0.25), (2.0, 0.0625)])
def test_driven_heat_is_a_power_of_its_input(exponent, share, jig_borer_lumps):
    one = HeatSource(("rotor", "speed"))
    grown = one.put_into(jig_borer_lumps, {"power": 80.0, "exponent": exponent})
    top = next(entry for entry in jig_borer_lumps.inputs if entry.name == "speed").high
    inputs = {entry.name: np.array([0.0]) for entry in jig_borer_lumps.inputs}
    inputs["speed"] = np.array([0.25 * top])
    more = network_of(grown).heat(inputs) - network_of(jig_borer_lumps).heat(inputs)
    expected = np.zeros(len(jig_borer_lumps.nodes))
    expected[jig_borer_lumps.node_index["rotor"]] = 80.0 * share
    np.testing.assert_allclose(more[0, 0], expected, atol=1e-9)


def test_steady_heat_is_there_at_standstill(jig_borer_lumps):
    grown = HeatSource(("stator",)).put_into(jig_borer_lumps, {"power": 30.0})
    inputs = {entry.name: np.array([0.0]) for entry in jig_borer_lumps.inputs}
    assert network_of(grown).heat(inputs)[0, 0, jig_borer_lumps.node_index["stator"]] == 30.0


def test_a_stirred_film_is_there_in_motion_only(jig_borer_lumps):
    change = ConductanceWithMotion(("rotor", "stator", "speed"))
    grown = network_of(change.put_into(jig_borer_lumps, {"conductance": 10.0}))
    plain = network_of(jig_borer_lumps)
    a, b = (jig_borer_lumps.node_index[name] for name in ("rotor", "stator"))
    top = next(entry for entry in jig_borer_lumps.inputs if entry.name == "speed").high
    for speed, added in ((0.0, 0.0), (top, 10.0), (0.5 * top, 10.0 * 0.5**0.7)):
        inputs = {entry.name: np.array([0.0]) for entry in jig_borer_lumps.inputs}
        inputs["speed"] = np.array([speed])
        more = grown.conductances(inputs)[0][0] - plain.conductances(inputs)[0][0]
        assert more[a, b] == pytest.approx(-added)
        assert more[a, a] == pytest.approx(added)


def test_both_have_a_form_in_c_and_take_part_in_every_step(jig_borer_lumps):
    driven = HeatSource(("rotor", "speed"))
    grown = driven.put_into(jig_borer_lumps, {"power": 80.0, "exponent": 1.0})
    film = ConductanceWithMotion(("rotor", "stator", "speed"))
    grown = film.put_into(grown, {"conductance": 10.0})
    assert equations_of(grown, []).levels == equations_of(jig_borer_lumps, []).levels
    inputs = inputs_over(0.5)
    moved = simulate(grown, inputs).run_frame() - simulate(jig_borer_lumps, inputs).run_frame()
    assert np.abs(moved.to_numpy()).max() > 0.1
    drive = drive_from(grown, inputs, 10.0)
    start = np.full((1, len(grown.nodes)), 21.0)
    assert np.isfinite(trajectories(grown, network_of(grown), [drive], [start])[0]).all()
