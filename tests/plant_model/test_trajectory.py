"""Temperatures are stepped once where parameter sets differ in nothing that warms."""

from typing import Any

import numpy as np
import pandas as pd
import pytest

import plant_model.trajectory as module
from plant_model.drive import drive_from
from plant_model.effects import catalogue
from plant_model.machine import Machine
from plant_model.machine_file import read_machine
from plant_model.network import Network, effects_in_force
from plant_model.parameters import FloatArray, Values
from plant_model.simulate import Driven, simulate, simulate_all
from plant_model.trajectory import NOT_WARMING, trajectories
from tests.plant_model.conftest import inputs_over, with_effects


def inputs_of(name: str, hours: float = 0.25) -> pd.DataFrame:
    frame = inputs_over(hours, every_s=60.0)
    machine = read_machine(name)
    for entry in machine.inputs:
        if entry.column not in frame:
            frame[entry.column] = 21.0 if entry.is_boundary else max(entry.low, 0.0)
    return frame


@pytest.mark.parametrize("name", ["jig_borer_lumps", "lathe"])
def test_what_is_said_not_to_warm_changes_no_temperature(name):
    """Every number of every effect that says so, and every number of the structure."""
    machine = with_effects(read_machine(name), *catalogue())
    inputs = inputs_of(name)
    plain = Values(machine.parameters)
    effects = effects_in_force(machine, plain)
    quiet = (*NOT_WARMING, *(f"effects.{one.key}." for one in effects if not one.warms))
    moved = {
        parameter: np.array([one.value, one.low, one.high])
        for parameter, one in machine.parameters.items()
        if parameter.startswith(quiet) and not one.tied and one.low < one.high
    }
    assert any(one.startswith("effects.slow_structure.") for one in moved)
    assert any(one.startswith("structure.") for one in moved)
    values = Values(machine.parameters, moved)
    network = Network(machine, values, effects_in_force(machine, values))
    drive = drive_from(machine, inputs, 60.0)
    start = np.broadcast_to(simulate(machine, inputs).temperatures[0, 0], (3, network.node_count))
    (whole,) = trajectories(machine, network, [drive], [start], 1e-3)
    found = whole[..., : network.node_count]
    # With one error control for all sets, steps are the same whatever else the sets have.
    np.testing.assert_allclose(found[1:], found[[0, 0]], atol=1e-9)


@pytest.mark.parametrize("temperature_dependent", [False, True])
def test_sets_that_share_temperatures_read_as_each_would_alone(temperature_dependent, monkeypatch):
    names = [
        "slow_structure",
        "sensor_lag",
        "sensor_offset",
        "column_bending",
        "bearing_stick_slip",
    ]
    machine = with_effects(
        read_machine("jig_borer_lumps"),
        *names,
        *(["thermal_preload", "tool_heating"] if temperature_dependent else []),
    )
    sets = {
        "effects.slow_structure.growth": np.array([0.5, 1.0, 1.0, 0.5]),
        "effects.sensor_lag:T1.minutes": np.array([2.0, 2.0, 6.0, 6.0]),
        "effects.sensor_offset:T1.error": np.array([0.5, 0.5, -0.5, 0.5]),
        "nodes.column.capacity": machine.parameters["nodes.column.capacity"].value
        * np.array([1.0, 1.0, 1.0, 1.1]),
    }
    inputs, stepped = inputs_of("jig_borer_lumps", 0.15), []
    step = module.trajectories

    def counted(machine: Machine, network: Network, *rest: Any) -> list[FloatArray]:
        stepped.append(network.sets)
        return step(machine, network, *rest)

    monkeypatch.setattr(module, "trajectories", counted)
    together = simulate(machine, inputs, sets, tolerance=1e-6)
    assert stepped == [2]
    for i in range(4):
        alone = simulate(machine, inputs, {k: v[i] for k, v in sets.items()}, tolerance=1e-6)
        for name, shown in alone.readings.items():
            np.testing.assert_allclose(together.readings[name][i], shown[0], atol=1e-4)


@pytest.mark.parametrize("key", ["coolant_thermostat", "bearing_run_in"])
def test_what_is_known_ahead_is_what_stepping_gives(key, monkeypatch):
    machine = with_effects(read_machine("jig_borer_lumps"), key)
    inputs = inputs_of("jig_borer_lumps", 2.0)
    ahead = simulate(machine, inputs)
    coarse = simulate(machine, inputs, step_s=120.0)
    monkeypatch.setattr(module, "FINE_S", np.inf)
    never = property(lambda self: False, lambda self, said: None)
    monkeypatch.setattr(catalogue()[key], "known_ahead", never)
    stepped = simulate(machine, inputs, tolerance=1e-5)
    plain = simulate(read_machine("jig_borer_lumps"), inputs)
    assert np.abs(stepped.temperatures - plain.temperatures).max() > 0.3
    # Every other row is an instant of the coarse grid; between them a swing is followed to 30 s.
    for one, every, within in ((ahead, 1, 2e-3), (coarse, 2, 0.02)):
        off = np.abs(one.temperatures - stepped.temperatures)[:, ::every]
        assert off.max() < within
        assert np.abs(one.pose - stepped.pose)[:, ::every].max() < 10.0 * within


def test_sets_that_start_elsewhere_share_nothing():
    machine = with_effects(read_machine("jig_borer_lumps"), "sensor_offset")
    starts = np.full((2, len(machine.nodes)), 20.0)
    starts[1] += 1.0
    found = simulate(machine, inputs_of("jig_borer_lumps"), start=starts)
    assert np.all(found.temperatures[1, 0] - found.temperatures[0, 0] == 1.0)
    assert np.all(found.temperatures[1, -1] > found.temperatures[0, -1])


@pytest.mark.parametrize(
    ("name", "key"),
    [
        ("jig_borer_lumps", "tool_heating"),
        ("jig_borer_lumps", "bearing_stick_slip"),
        ("lathe", ""),
        pytest.param("jig_borer_lumps", "", marks=pytest.mark.long),
        pytest.param("lathe", "tool_heating", marks=pytest.mark.long),
        pytest.param("lathe", "bearing_stick_slip", marks=pytest.mark.long),
    ],
)
def test_runs_side_by_side_read_as_each_would_alone(name, key):
    """Runs of unlike lengths and speeds, stepped in parts and sought at instants of their own."""
    machine = with_effects(read_machine(name), *([key, "thermal_preload"] if key else []))
    names = ["nodes.column.capacity"] if name == "jig_borer_lumps" else ["nodes.bed.capacity"]
    sets = {one: machine.parameters[one].value * np.array([1.0, 1.05, 0.9]) for one in names}
    frames = [inputs_of(name, hours) for hours in (0.3, 1.1, 0.7)]
    speed = machine.inputs[0].column if not machine.inputs[0].is_boundary else "speed_rpm"
    frames[2] = frames[2].assign(**{speed: np.roll(frames[2][speed].to_numpy(), 7)})
    runs = [
        Driven(frame, drive_from(machine, frame, step_s), frame["time_s"].to_numpy()[3::4])
        for frame, step_s in zip(frames, (600.0, 120.0, 900.0), strict=True)
    ]
    together = simulate_all(machine, runs, sets, tolerance=1e-5)
    assert len({len(one.drive.grid) for one in runs}) == 3
    for run, side in zip(runs, together, strict=True):
        (alone,) = simulate_all(machine, [run], sets, tolerance=1e-5)
        assert np.ptp(alone.temperatures) > 0.1
        np.testing.assert_allclose(side.temperatures, alone.temperatures, atol=1e-10)
        for channel, shown in alone.readings.items():
            np.testing.assert_allclose(side.readings[channel], shown, atol=1e-9)
