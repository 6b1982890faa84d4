"""Sets near one another, to first order about the first."""

import numpy as np
import pytest

from plant_model import trajectory
from plant_model.drive import drive_from
from plant_model.machine_file import read_machine
from plant_model.simulate import Driven, simulate_all
from tests.plant_model.conftest import with_effects
from tests.plant_model.test_trajectory import inputs_of

PATH = "links.front_outer-housing_front_xp.conductance"
MOVED = ["nodes.column.capacity", PATH, "sources.motor.loss"]


@pytest.mark.parametrize("keys", [[], ["thermal_preload", "tool_heating"]])
def test_what_sets_near_the_first_differ_by_is_their_derivative(keys):
    machine = with_effects(read_machine("jig_borer_lumps"), *keys)
    names = [*MOVED, "effects.thermal_preload.gain"] if keys else MOVED
    way = 0.005 * np.eye(len(names) + 1, len(names), -1)
    values = np.array([machine.parameters[one].value for one in names])
    frame = inputs_of("jig_borer_lumps", 1.0)
    runs = [Driven(frame, drive_from(machine, frame, 60.0))]

    def shown(shares, **options):
        sets = dict(zip(names, (values * (1.0 + shares)).T, strict=True))
        (run,) = simulate_all(machine, runs, sets, tolerance=1e-4, bounded=False, **options)
        return np.concatenate([run.temperatures, run.pose], axis=2)[:, 10:]

    near = shown(way, near=True)
    expected = (shown(way) - shown(-way))[1:] / 2.0
    for found, wanted in zip(near[1:] - near[0], expected, strict=True):
        assert np.linalg.norm(found - wanted) < 0.03 * np.linalg.norm(wanted)


@pytest.mark.parametrize(
    "keys", [["viscosity_temperature"], ["tool_heating", "coolant_thermostat"]]
)
def test_a_trajectory_that_was_just_stepped_is_not_stepped_again(keys, monkeypatch):
    machine = with_effects(read_machine("jig_borer_lumps"), *keys)
    capacity = machine.parameters[MOVED[0]].value * np.array([0.9, 1.0, 1.1])
    frame = inputs_of("jig_borer_lumps", 1.0)
    runs = [Driven(frame, drive_from(machine, frame, 60.0))]
    stepped = []
    step = trajectory.trajectories
    monkeypatch.setattr(
        trajectory, "trajectories", lambda *given: stepped.append(1) or step(*given)
    )

    def near(values):
        (run,) = simulate_all(machine, runs, {MOVED[0]: values}, bounded=False, near=True)
        return run.temperatures

    fresh = near(capacity[1:])
    simulate_all(machine, runs, {MOVED[0]: capacity}, bounded=False)
    del stepped[:]
    assert near(capacity[1:]) == pytest.approx(fresh, abs=0.01)
    assert not stepped
    assert near(capacity[1:] * 1.01).shape == fresh.shape
    other = [Driven(frame, drive_from(machine, frame, 60.0))]
    simulate_all(machine, other, {MOVED[0]: capacity[1:]}, bounded=False, near=True)
    assert len(stepped) == 2


def test_a_trajectory_on_a_coarser_grid_is_not_taken_for_one_with_a_clock():
    # A thermostat that is off in all sets needs no fine steps; its derivatives do.
    keys = "viscosity_temperature", "coolant_thermostat"
    machine = with_effects(read_machine("jig_borer_lumps"), *keys)
    amplitude = "effects.coolant_thermostat.band"
    frame = inputs_of("jig_borer_lumps", 1.0)
    runs = [Driven(frame, drive_from(machine, frame, 60.0))]
    (off,) = simulate_all(machine, runs, {amplitude: np.zeros(2)}, bounded=False)
    (near,) = simulate_all(machine, runs, {amplitude: np.array([0.0, 1.0])}, near=True)
    assert near.temperatures[0] == pytest.approx(off.temperatures[0], abs=0.01)
    assert near.temperatures.shape[1] == off.temperatures.shape[1]
