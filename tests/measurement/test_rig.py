"""Rigs: readings to pose and back."""

import math
from typing import Any

import numpy as np
import numpy.testing as npt
import pandas as pd
import pytest
from hypothesis import given
from hypothesis import strategies as st

from measurement.errors import BadInput
from measurement.rig import POSE, FivePointRig, axis_of, default_rig, rig_from_table
from measurement.runs import Run, read_run
from tests.five_point import readings_of
from tests.refusing import refusal

JIG_BORER = {"kind": "five_point", "spacing_mm": 100.0, "near_to_gauge_mm": 30.0}
COLUMNS = ["S1_um", "S2_um", "S3_um", "S4_um", "S5_um"]


def five_point(**changes: Any) -> FivePointRig:
    return rig_from_table(JIG_BORER | changes, "machine.toml")


def readings(*values: float) -> pd.DataFrame:
    return pd.DataFrame([values], columns=COLUMNS)


def run_of(**columns: list[float]) -> Run:
    first = next(iter(columns.values()))
    return Run("r", pd.DataFrame({"time_s": np.arange(float(len(first))), **columns}))


def test_a_known_pose():
    # 10 um over 100 mm is a tilt of atan(1e-4); S5 falls by 40 um as the spindle grows by 40 um.
    pose = five_point().pose(readings(2.0, -3.0, 12.0, -13.0, -40.0)).iloc[0]
    assert pose["elongation_um"] == 40.0
    assert pose["yaw_urad"] == pytest.approx(1e6 * math.atan(1e-4), rel=1e-15)
    assert pose["pitch_urad"] == pytest.approx(-1e6 * math.atan(1e-4), rel=1e-15)
    assert (pose["near_x_um"], pose["near_y_um"]) == (2.0, -3.0)
    assert tuple(pose.index) == POSE


SIGNS = st.sampled_from([1, -1])


@given(
    values=st.lists(st.floats(-500, 500), min_size=5, max_size=5),
    spacing=st.floats(5, 500) | st.floats(-500, -5),
    bar=st.floats(-500, 500),
    signs=st.tuples(SIGNS, SIGNS, SIGNS, SIGNS, SIGNS),
)
def test_readings_invert_the_pose(values, spacing, bar, signs):
    names = ("near_x_sign", "near_y_sign", "distal_x_sign", "distal_y_sign", "axial_sign")
    rig = five_point(spacing_mm=spacing, test_bar_mm=bar, **dict(zip(names, signs, strict=True)))
    frame = readings(*values)
    pose = rig.pose(frame)
    npt.assert_allclose(readings_of(rig, pose), frame, rtol=0, atol=1e-9)
    npt.assert_allclose(rig.pose(readings_of(rig, pose)), pose, rtol=0, atol=1e-9)


def test_each_sign_turns_its_own_reading():
    frame = readings(1.0, 2.0, 4.0, 8.0, 16.0)
    for place, name in zip(
        ("near_x_sign", "near_y_sign", "distal_x_sign", "distal_y_sign"), COLUMNS, strict=False
    ):
        turned = frame.assign(**{name: -frame[name]})
        pd.testing.assert_frame_equal(
            five_point(**{place: -1}).pose(frame), five_point().pose(turned)
        )
    assert five_point(axial_sign=1).pose(frame)["elongation_um"][0] == 16.0


def test_a_tilted_bar_seems_shorter_by_its_cosine():
    # A bar of 200 mm that only tilts by 1 mrad draws its end back by 200 mm (1 - cos) = 0.1 um.
    tilted = readings(0.0, 0.0, 100.0, 0.0, 0.0)
    shortened = 200e3 * (1 - math.cos(math.atan(1e-3)))
    rig = five_point(test_bar_mm=200.0)
    assert rig.pose(tilted)["elongation_um"][0] == pytest.approx(shortened, rel=1e-5)
    assert five_point().pose(tilted)["elongation_um"][0] == 0.0


def test_a_missing_reading_costs_only_what_needs_it():
    pose = five_point().pose(readings(math.nan, 0.0, 1.0, 2.0, 3.0)).iloc[0]
    assert pose.isna().tolist() == [False, True, False, True, False]


@pytest.mark.parametrize(
    ("change", "expected"),
    [
        ({"kind": "direct", "axes": {"a": {"axis": "X"}, "b": {"axis": "X"}}}, "has two columns"),
        ({"spacing_mm": 0.0}, "must be at least 1 mm in either direction"),
        ({"spacing_mm": math.inf}, "spacing_mm: "),
        ({"spacing_mm": "wide"}, "spacing_mm: 'wide' is not allowed"),
        ({"axial_sign": 2}, "axial_sign: 2 is not allowed"),
        ({"near_x": "S3"}, "sensor 'S3' has two places"),
        ({"near_x": ""}, "near_x: '' is not allowed"),
        ({"colour": "red"}, "colour: is not a known field"),
        ({"kind": "laser"}, "kind: 'laser' is not allowed: five_point or direct"),
        ({"kind": "direct"}, "is missing"),
    ],
)
def test_a_wrong_table_is_refused_in_one_line(change, expected):
    table = change if "axes" in change else JIG_BORER | change
    said = refusal(rig_from_table, table, "machine.toml")
    assert said.startswith("machine.toml: ")
    assert expected in said


def test_columns_that_are_not_there_are_named():
    with pytest.raises(BadInput, match="distal_y: the run has no column S4_um"):
        five_point().pose(readings(1, 2, 3, 4, 5).drop(columns="S4_um"))
    with pytest.raises(BadInput, match=r"no column disp_x_um .it has no displacement column"):
        rig_from_table({"kind": "direct", "axes": {"disp_x": {"axis": "X"}}}, "m").targets(
            run_of(T1_degC=[1.0])
        )


def test_a_direct_rig_gives_columns_and_drift_by_its_signs():
    rig = rig_from_table(
        {"kind": "direct", "axes": {"growth": {"axis": "Z", "sign": -1}, "d": {"axis": "X"}}}, "m"
    )
    run = run_of(growth_um=[1.0, 2.0], d_um=[3.0, 4.0], other_um=[0.0, 0.0])
    assert rig.targets(run).to_dict("list") == {"growth_um": [1.0, 2.0], "d_um": [3.0, 4.0]}
    drift = rig.drift(run.frame)
    assert drift.to_dict("list") == {"drift_X_um": [3.0, 4.0], "drift_Z_um": [-1.0, -2.0]}


@pytest.mark.parametrize(
    ("signal", "axis"),
    [
        ("disp_x", ("X", 1)),
        ("drift_Y", ("Y", 1)),
        ("Z", ("Z", 1)),
        ("growth", ("Z", -1)),
        ("axial_growth", ("Z", -1)),
        ("growth_z", ("Z", 1)),
        ("S1", None),
        ("max", None),
        ("x_to_y", None),
    ],
)
def test_the_axis_that_a_name_tells(signal, axis):
    assert axis_of(signal) == axis


def test_the_default_rig_is_the_machines_where_it_fits_and_else_by_name():
    five = run_of(**{name: [0.0] for name in COLUMNS})
    assert default_rig(five, JIG_BORER) == five_point()
    assert default_rig(five, five_point(axial_sign=1)) == five_point(axial_sign=1)
    direct = default_rig(run_of(disp_x_um=[0.0], disp_z_um=[0.0]), JIG_BORER)
    assert {name: (a.axis, a.sign) for name, a in direct.axes.items()} == {
        "disp_x": ("X", 1),
        "disp_z": ("Z", 1),
    }
    plant = run_of(drift_X_um=[0.0], offset_X_um=[0.0], error_X_um=[0.0])
    assert default_rig(plant).columns == ["drift_X_um"]


@pytest.mark.parametrize(
    ("columns", "expected"),
    [
        ({"S1_um": [0.0]}, "no displacement column names its axis .*S1_um"),
        ({"T1_degC": [0.0]}, "it has no displacement column"),
        (
            {"z_mm": [0.0], "tool_mm": [0.0]},
            r"not mm \(spindle-drift import converts drifts\): z_mm\)",
        ),
        ({"a_x_um": [0.0], "b_x_um": [0.0]}, "columns a_x_um and b_x_um both stand for axis X"),
    ],
)
def test_a_run_that_does_not_tell_is_refused_with_what_to_give(columns, expected):
    with pytest.raises(BadInput, match=expected + ".*give a machine file"):
        default_rig(run_of(**columns))


@pytest.mark.real_data
def test_the_measured_runs_tell_their_axes(lathe_runs, electric_spindle_run):
    run = read_run(lathe_runs[0])
    assert list(default_rig(run).targets(run)) == ["disp_x_um", "disp_z_um"]
    spindle = read_run(electric_spindle_run)
    rig = default_rig(spindle)
    # It grows as it warms: the nose goes towards -Z.
    assert rig.drift(spindle.frame)["drift_Z_um"].iloc[-1] < -10.0


@given(st.lists(st.floats(-60, 60), min_size=5, max_size=5))
def test_the_small_angle_form_agrees_to_a_nanoradian(values):
    # 60 um at each sensor is beyond what the studies' spindles do in any run.
    rig = five_point()
    near_x, near_y, distal_x, distal_y, _ = values
    small = 1e3 / rig.spacing_mm * np.array([distal_x - near_x, distal_y - near_y])
    exact = rig.pose(readings(*values))[["yaw_urad", "pitch_urad"]].to_numpy()[0]
    npt.assert_allclose(small, exact, rtol=0, atol=1e-3)  # urad
