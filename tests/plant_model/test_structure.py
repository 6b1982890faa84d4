"""From temperatures to displacements: which bearing locates, where the nose goes, what is read."""

import math
from dataclasses import replace

import numpy as np
import pytest

from plant_model.effects.base import POSE
from plant_model.machine import Machine
from plant_model.network import effects_in_force
from plant_model.parameters import FloatArray, Values
from plant_model.sensors import displacements
from plant_model.structure import drift_at, pose


def pose_for(machine: Machine, warm: dict[str, float]) -> dict[str, float]:
    rise = np.zeros((1, 1, len(machine.nodes)))
    for name, value in warm.items():
        rise[..., machine.node_index[name]] = value
    effects = effects_in_force(machine, Values(machine.parameters))
    inputs = {entry.name: np.zeros(1) for entry in machine.inputs}
    found = pose(effects, {}, inputs, rise, np.zeros((1, 1, 0)))[0, 0]
    return dict(zip(POSE, found.tolist(), strict=True))


def test_shaft_grows_from_the_bearing_that_locates(jig_borer_lumps):
    # Front bearing at 300 mm, gauge line at 400 mm: 100 mm of front shaft push the nose.
    front = pose_for(jig_borer_lumps, {"shaft_front": 10.0})
    assert front["elongation"] == pytest.approx(11.5e-3 * 100.0 * 10.0)
    assert pose_for(jig_borer_lumps, {"shaft_rear": 10.0})["elongation"] == 0.0
    # Located at the rear, at -100 mm, the whole shaft pushes and the housing pulls back.
    (located,) = jig_borer_lumps.of_kind("structure", "located")
    rear = jig_borer_lumps.with_values({located.parameter_name("at"): -100.0}, beyond=True)
    assert pose_for(rear, {"shaft_front": 10.0})["elongation"] == pytest.approx(11.5e-3 * 2000.0)
    assert pose_for(rear, {"shaft_rear": 10.0})["elongation"] == pytest.approx(11.5e-3 * 1000.0)
    assert pose_for(rear, {"housing_rear": 10.0})["elongation"] == pytest.approx(-11.5e-3 * 1000.0)


def test_even_warming_of_a_ring_does_not_tilt(jig_borer_lumps):
    ring = {f"housing_motor_{sector}": 3.0 for sector in ("xp", "xm", "yp", "ym")}
    found = pose_for(jig_borer_lumps, ring)
    assert found["elongation"] == pytest.approx(11.5e-3 * 180.0 * 3.0)
    for axis in ("yaw", "pitch", "x", "y"):
        assert found[axis] == pytest.approx(0.0, abs=1e-12)


def test_a_warm_side_tilts_the_nose_away(jig_borer_lumps):
    found = pose_for(jig_borer_lumps, {"housing_motor_xm": 2.0})
    yaw = 11.5 * 2.0 * 180.0 / 180.0
    assert found["yaw"] == pytest.approx(yaw)
    assert found["x"] == pytest.approx(yaw * 310.0 * 1e-3)
    assert found["pitch"] == 0.0


def test_drift_at_a_length_against_exact_geometry():
    yaw, pitch, length = 300.0, -200.0, 150.0
    state = np.array([4.0, -3.0, 20.0, yaw, pitch, 0.05])
    # A stiff tool along the direction (tan yaw, tan pitch, -1), of unit length.
    direction = np.array([math.tan(yaw * 1e-6), math.tan(pitch * 1e-6), -1.0])
    tip = np.array([4.0, -3.0, -20.0]) + length * 1e3 * np.array(
        [direction[0], direction[1], 1.0 - 1.0 / np.linalg.norm(direction)]
    )
    tip[2] -= 0.05 * length
    np.testing.assert_allclose(drift_at(state, length), tip, rtol=1e-9)


def test_rig_reads_what_the_pose_says(jig_borer_lumps):
    state: FloatArray = np.array([[[5.0, 6.0, 30.0, 100.0, -50.0, 0.02]]])
    read = {
        name: float(value[0, 0]) for name, value in displacements(jig_borer_lumps, state).items()
    }
    assert read["S1"] == pytest.approx(5.0 + 30.0 * 0.1)
    assert read["S2"] == pytest.approx(6.0 - 30.0 * 0.05)
    assert (read["S3"] - read["S1"]) / 100.0 * 1e3 == pytest.approx(100.0)
    assert (read["S4"] - read["S2"]) / 100.0 * 1e3 == pytest.approx(-50.0)
    assert read["S5"] == pytest.approx(-(30.0 + 0.02 * 150.0), abs=1e-3)


def test_direct_rig_reads_named_displacements(jig_borer_lumps):
    rig = {
        "kind": "direct",
        "axes": {"disp_x": {"axis": "X", "sign": -1}, "disp_z": {"axis": "Z", "sign": 1}},
        "noise_um": 0.0,
        "resolution_um": 0.0,
    }
    state = np.array([[[5.0, 6.0, 30.0, 0.0, 0.0, 0.0]]])
    read = displacements(replace(jig_borer_lumps, rig=rig), state)
    assert {name: float(value[0, 0]) for name, value in read.items()} == {
        "disp_x": -5.0,
        "disp_z": -30.0,
    }
