"""A machine's rig means in the plant what it means where a compensator is fitted."""

from dataclasses import replace

import numpy as np
import pytest

from measurement.rig import FivePointRig
from plant_model.simulate import simulate
from tests.plant_model.conftest import inputs_over

TURNED = {f"{role}_sign": -1 for role in ("near_x", "near_y", "distal_x", "distal_y")}


@pytest.mark.parametrize(
    "other",
    [
        TURNED,
        {"near_y_sign": -1},
        {"axial_sign": 1},
        {"spacing_mm": -60.0, "near_to_gauge_mm": 90.0},
    ],
)
def test_any_rig_sees_the_same_pose(jig_borer_lumps, other):
    inputs = inputs_over(1.0, every_s=60.0)
    given = {name: value for name, value in jig_borer_lumps.rig.items() if name != "kind"}
    poses = []
    for rig in (given, given | other):
        machine = replace(jig_borer_lumps, rig={"kind": "five_point", **rig})
        frame = simulate(machine, inputs).run_frame()
        pose = FivePointRig(**rig).pose(frame)
        poses.append(pose[["elongation_um", "yaw_urad", "pitch_urad"]].to_numpy())
    assert np.abs(poses[0]).max() > 1.0
    np.testing.assert_allclose(poses[1], poses[0], atol=0.02)
