"""The drift of the tool tip."""

from math import cos, sin

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fmu_compensator.runtime.fields import Fields
from fmu_compensator.runtime.geometry import Direct, FivePoint, geometry_from_fields

RIGID = FivePoint("rigid", 30.0, 100.0)
ROTATION = FivePoint("pure_rotation", 30.0, 100.0)


def test_reference_values():
    # 100 urad of yaw over 150 - 30 mm is 12 um, and 50 urad of pitch the other way 6 um.
    x, y, z = RIGID.drift([20.0, 100.0, -50.0, 5.0, 3.0], 150.0)
    assert x == pytest.approx(5.0 + 12.0, abs=1e-6)
    assert y == pytest.approx(3.0 - 6.0, abs=1e-6)
    # -20 um, and 150 mm (1 - cos) = 150e3 um * (1e-8 + 0.25e-8) / 2
    assert z == pytest.approx(-20.0 + 150e3 * 1.25e-8 / 2, abs=1e-6)


def test_pure_rotation_is_the_rigid_form_without_drift_at_the_gauge_line():
    yaw, pitch = 120.0, -30.0
    at_gauge = RIGID.drift([0.0, yaw, pitch, 0.0, 0.0], 0.0)
    rigid = RIGID.drift([9.0, yaw, pitch, -at_gauge[0], -at_gauge[1]], 180.0)
    turned = ROTATION.drift([9.0, yaw, pitch, 55.0, 66.0], 180.0)
    assert turned == pytest.approx(rigid, abs=1e-9)


@given(st.floats(-500, 500), st.floats(0, 300), st.floats(-100, 100))
def test_z_is_the_tip_of_the_turned_and_grown_tool(yaw, length, elongation):
    z = RIGID.drift([elongation, yaw, 0.0, 0.0, 0.0], length)[2]
    um = length * 1e3
    half = sin(yaw * 1e-6 / 2)
    assert z == pytest.approx(2 * um * half**2 - elongation * cos(yaw * 1e-6), abs=1e-8)
    assert z == pytest.approx(-elongation, abs=0.05)


def test_direct_columns_go_to_their_axes():
    geometry = Direct({"growth": ("Z", -1), "side": ("X", 1)})
    assert geometry.targets == ("growth", "side")
    assert geometry.drift([12.0, 3.0], 500.0) == (3.0, 0.0, -12.0)
    assert geometry.pose([12.0, 3.0]) == (12.0, 0.0, 0.0)
    assert Direct({"side": ("Y", -1)}).pose([4.0]) == (0.0, 0.0, 0.0)
    assert Direct({"side": ("Y", -1)}).drift([4.0], 0.0) == (0.0, -4.0, 0.0)


def test_tables_make_geometries():
    table = {"kind": "five_point", "form": "rigid", "near_to_gauge_mm": -5, "spacing_mm": -80}
    geometry = geometry_from_fields(Fields(table, "f"))
    assert (geometry.near_to_gauge_mm, geometry.spacing_mm) == (-5.0, -80.0)
    assert geometry.needs_tool_length
    for spacing in (0, "80"):
        with pytest.raises(ValueError, match="spacing_mm"):
            geometry_from_fields(Fields(table | {"spacing_mm": spacing}, "f"))
