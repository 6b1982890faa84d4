"""Effects of the catalogue that move the nose or a reading, against hand calculations."""

from dataclasses import replace
from typing import Any

import numpy as np
import pandas as pd
import pytest

from plant_model.effects import catalogue
from plant_model.machine_file import read_machine
from plant_model.simulate import simulate
from tests.plant_model.catalogue_machines import TEMPERATURES, change, heat_of, lathe, made, steady
from tests.plant_model.conftest import inputs_over


def hall_step(hours: float) -> pd.DataFrame:
    inputs = steady(0.0, hours)
    inputs["T5_degC"] = np.where(inputs["time_s"] > 0.0, 22.0, 21.0)
    return inputs


def test_column_bending_tilts_at_rest_with_its_lag(jig_borer_lumps):
    inputs = hall_step(2.0)
    own = {"tilt": 10.0, "hours": 2.0, "direction": 90.0, "lever": 200.0}
    moved, with_it, without = change(jig_borer_lumps, "column_bending", inputs, **own)
    pose = (with_it.pose - without.pose)[0]
    column = with_it.temperatures[0, :, jig_borer_lumps.node_index["column"]] - 21.0
    # Close to -10 urad/K * 1 K * (1 - 1/e), less what the column itself has followed meanwhile.
    assert np.all(column < 0.5)
    assert -10.0 * (1.0 - np.exp(-1.0)) < pose[-1, 4] < -10.0 * (1.0 - np.exp(-1.0)) * 0.6
    np.testing.assert_allclose(pose[:, 1], pose[:, 4] * 0.2, atol=1e-12)
    np.testing.assert_allclose(pose[:, [0, 2, 3]], 0.0, atol=1e-12)
    assert max(np.abs(moved[name]).max() for name in TEMPERATURES) < 1e-9


def test_slow_structure_follows_the_hall_for_hours(jig_borer_lumps):
    inputs = hall_step(8.0)
    moved, with_it, without = change(
        jig_borer_lumps, "slow_structure", inputs, growth=6.0, hours=8.0
    )
    pose = (with_it.pose - without.pose)[0]
    assert pose[-1, 2] == pytest.approx(6.0 * (1.0 - np.exp(-1.0)), rel=5e-3)
    # It never settles: the last hour still moves it.
    assert pose[-1, 2] - pose[-61, 2] > 0.2
    np.testing.assert_allclose(np.delete(pose, 2, axis=1), 0.0, atol=1e-12)
    assert max(np.abs(moved[name]).max() for name in TEMPERATURES) < 1e-9
    own = {"direction": 90.0, "azimuth": 0.0}
    _, with_it, without = change(jig_borer_lumps, "slow_structure", inputs, growth=6.0, **own)
    assert (with_it.pose - without.pose)[0, -1, 0] == pytest.approx(pose[-1, 2])


def test_centrifugal_shift_is_instant_and_in_the_elongation_only(jig_borer_lumps):
    inputs = steady(0.0, 1.0)
    inputs["speed_rpm"] = np.where(inputs["time_s"] < 1800.0, 0.0, 10000.0)
    moved, with_it, without = change(jig_borer_lumps, "centrifugal_shift", inputs, shift=12.0)
    pose = (with_it.pose - without.pose)[0]
    # 12 um * (10000 / 20000)^2, there in the first row at speed and no more later.
    expected = np.where(inputs["time_s"] < 1800.0, 0.0, 3.0)
    np.testing.assert_allclose(pose[:, 2], expected, atol=1e-12)
    np.testing.assert_allclose(np.delete(pose, 2, axis=1), 0.0, atol=1e-12)
    assert all(np.all(moved[name] == 0.0) for name in TEMPERATURES)


def test_bearing_stick_slip_jumps_and_depends_on_the_path(jig_borer_lumps):
    inputs = steady(12000.0, 5.0)
    inputs["speed_rpm"] = np.where(inputs["time_s"] < 2 * 3600.0, 12000.0, 0.0)
    moved, with_it, without = change(
        jig_borer_lumps, "bearing_stick_slip", inputs, hold=6.0, share=0.5
    )
    elongation = (with_it.pose - without.pose)[0, :, 2]
    # Half of 6 um is held at most; a slip drops it within two minutes, in either direction.
    assert np.abs(elongation).max() == pytest.approx(3.0, rel=0.15)
    drop = elongation[2:] - elongation[:-2]
    assert drop.min() < -1.8
    assert drop.max() > 1.8
    assert np.abs(elongation[-1]) > 0.1, "cold again, the nose does not come back"
    # Temperatures are as without it, but for the error control that the relay calls for.
    assert max(np.abs(moved[name]).max() for name in TEMPERATURES) < 1e-6


def test_uneven_bearing_heating_tilts_with_speed_and_not_at_rest():
    own = {"difference": 2.0, "minutes": 20.0, "direction": 0.0, "slenderness": 1.0}
    machine, hall = lathe(), {"hall_degC": 21.0}  # whose headstock is one lump
    inputs = steady(2000.0, 3.0).assign(**hall)
    _, with_it, without = change(machine, "uneven_bearing_heating", inputs, **own)
    assert np.all(with_it.temperatures == without.temperatures)
    pose = (with_it.pose - without.pose)[0]
    # 11.5e-6/K * 2 K * L / w = 23 urad at half of the highest speed, 1 - 1/e of it after 20 min.
    assert pose[-1, 3] == pytest.approx(23.0, rel=1e-3)
    assert pose[20, 3] == pytest.approx(23.0 * (1.0 - np.exp(-1.0)), rel=1e-6)
    assert pose[-1, 0] == pytest.approx(2.3, rel=1e-3)
    rest = steady(0.0, 1.0).assign(**hall)
    _, with_it, without = change(machine, "uneven_bearing_heating", rest, **own)
    assert np.all(with_it.pose == without.pose)


@pytest.mark.parametrize(
    ("direction", "warm", "cold", "axis"), [(0.0, "xm", "xp", 3), (90.0, "ym", "yp", 4)]
)
def test_uneven_bearing_heating_warms_one_side_of_a_housing_in_sectors(
    jig_borer_lumps, direction, warm, cold, axis
):
    own = {"difference": 2.0, "slenderness": 0.3, "direction": direction}
    _, effect = made(jig_borer_lumps, "uneven_bearing_heating", **own)
    (link,) = (
        item
        for item in jig_borer_lumps.of_kind("links", "conduction", "contact")
        if set(item.refs["between"]) == {"front_outer", f"housing_front_{warm}"}
    )
    # 1 K warmer on one side at half of the highest speed, and 1 K colder opposite.
    moved = heat_of(effect, 10000.0, states=[1.0])
    watts = link.parameters["conductance"].value
    assert moved[f"housing_front_{warm}"] == pytest.approx(watts)
    assert moved[f"housing_front_{cold}"] == pytest.approx(-watts)
    assert sum(moved.values()) == pytest.approx(0.0, abs=1e-9)
    inputs = steady(10000.0, 3.0)
    _, with_it, without = change(jig_borer_lumps, "uneven_bearing_heating", inputs, **own)
    pose = (with_it.pose - without.pose)[0, -1]
    alone = 11.5 * 2.0 * 0.3
    assert pose[axis] > alone + 1.0, "the housing bends the same way as the ring"
    assert abs(pose[7 - axis]) < 0.5 * pose[axis]


def test_tool_heating_ends_in_the_balance_of_its_own_states():
    machine, effect = made(lathe(), "tool_heating", conductance=3.0, loss=1.0, capacity=900.0)
    quill = 31.0
    # 3 (11 - h) = 0.5 h + 0.5 (h - t) and 0.5 (h - t) = 0.5 t: t = h / 2, h = 33 / 3.75 = 8.8 K.
    now = np.array([[[quill if node.name == "quill" else 20.0 for node in machine.nodes]]])
    inputs: dict[str, Any] = {"hall": np.array([20.0])}
    balance = [28.8, 24.4, 18.0]
    np.testing.assert_allclose(effect.rate(inputs, now, np.array([[balance]])), 0.0, atol=1e-12)
    heat = heat_of(effect, 0.0, {"quill": quill}, balance)
    assert heat["quill"] == pytest.approx(-3.0 * (11.0 - 8.8))


def test_a_tool_at_rest_grows_with_the_hall():
    machine = lathe()
    assert not machine.of_kind("structure", "tool")
    time = np.arange(0.0, 14 * 3600.0 + 1.0, 300.0)
    hall = 20.0 + 4.0 * np.minimum(time / 7200.0, 1.0)
    inputs = pd.DataFrame({"time_s": time, "speed_rpm": 0.0, "hall_degC": hall})
    own = {"holder_length": 100.0, "capacity": 600.0, "loss": 3.0, "conductance": 1.0}
    _, with_it, without = change(machine, "tool_heating", inputs, **own)
    pose = (with_it.pose - without.pose)[0]
    # Hall and quill are 4 K warmer in the end, and so is the holder: 11.5e-3 * 100 mm * 4 K.
    assert pose[-1, 2] == pytest.approx(4.6, rel=0.05)
    assert pose[-1, 5] == pytest.approx(0.046, rel=0.05)
    assert 0.0 < pose[12, 2] < 0.5 * pose[-1, 2], "later than the hall"


def test_a_tool_of_the_structure_follows_the_hall_by_itself(jig_borer_lumps):
    inputs = steady(0.0, 8.0)
    inputs["T5_degC"] = 21.0 + 3.0 * np.minimum(inputs["time_s"] / 7200.0, 1.0)
    inputs["T9_degC"] = inputs["T5_degC"]
    _, with_it, without = change(jig_borer_lumps, "tool_heating", inputs)
    pose = (with_it.pose - without.pose)[0]
    assert abs(pose[-1, 5]) < 0.1 * without.pose[0, -1, 5], "its growth is not counted twice"
    assert pose[-1, 2] == pytest.approx(11.5e-3 * 80.0 * 3.0, rel=0.1)


def test_fixture_warming_moves_radial_readings_together_without_tilt(jig_borer_lumps):
    own = {"growth": 3.0, "minutes": 30.0, "nose_share": 0.0, "direction": 60.0}
    turned = replace(jig_borer_lumps, rig=jig_borer_lumps.rig | {"distal_x_sign": -1})
    moved, with_it, without = change(turned, "fixture_warming", hall_step(5.0), **own)
    # 3 um/K * 1 K after ten time constants: cos 60 of it along X, sin 60 along Y.
    assert moved["S1"][-1] == pytest.approx(1.5, rel=1e-3)
    assert moved["S2"][-1] == pytest.approx(3.0 * np.sin(np.radians(60.0)), rel=1e-3)
    np.testing.assert_allclose(moved["S1"], -moved["S3"], atol=1e-12)
    np.testing.assert_allclose(moved["S2"], moved["S4"], atol=1e-12)
    assert np.all(moved["S5"] == 0.0)
    assert np.all(with_it.pose == without.pose), "the spindle has not moved"
    assert all(np.all(moved[name] == 0.0) for name in TEMPERATURES)


def test_a_probe_s_bracket_moves_its_reading_alone(jig_borer_lumps):
    turned = replace(jig_borer_lumps, rig=jig_borer_lumps.rig | {"distal_x_sign": -1})
    own = {"growth": -3.0, "minutes": 30.0, "nose_share": 0.0}
    moved, with_it, without = change(turned, "probe_warming:S3", hall_step(5.0), **own)
    # -3 um/K * 1 K after ten time constants, read with the probe's own sign.
    assert moved["S3"][-1] == pytest.approx(3.0, rel=1e-3)
    assert all(np.all(series == 0.0) for name, series in moved.items() if name != "S3")
    assert np.all(with_it.pose == without.pose), "the spindle has not moved"


def test_only_a_probe_beside_another_on_its_axis_has_a_bracket(jig_borer_lumps):
    law = catalogue()["probe_warming"]
    assert list(law.drivers(jig_borer_lumps)) == ["S1", "S2", "S3", "S4"]
    assert not law.drivers(read_machine("lathe"))


@pytest.mark.parametrize("name", ["sensor_lag", "sensor_offset", "sensor_drift"])
def test_a_thermometer_s_error_is_in_its_channel_only(name, jig_borer_lumps):
    moved, with_it, without = change(jig_borer_lumps, name, inputs_over(1.0))
    assert np.abs(moved["T1"]).max() > 0.05
    assert all(np.all(series == 0.0) for key, series in moved.items() if key != "T1")
    assert np.all(with_it.temperatures == without.temperatures)


def test_sensor_lag_is_late_by_its_time_constant_on_a_ramp(jig_borer_lumps):
    inputs = steady(0.0, 2.0)
    lag = {"sensor_lag:T5": dict(catalogue()["sensor_lag"].parameters)}
    machine = replace(jig_borer_lumps, effects=jig_borer_lumps.effects | lag)
    ramp = inputs.assign(T5_degC=21.0 + inputs["time_s"] / 3600.0)
    for minutes, settled in ((6.0, 0.1), (0.2, 0.2 / 60.0)):
        key = "effects.sensor_lag:T5.minutes"
        result = simulate(machine.with_values({key: minutes}), ramp)
        # A ramp of 1 K/h: late by 6 min is low by 0.1 K.
        error = result.readings["T5"][0, -1] - ramp["T5_degC"].iloc[-1]
        assert error == pytest.approx(-settled, rel=1e-3)


def test_sensor_offset_and_drift_have_their_size(jig_borer_lumps):
    inputs = steady(6000.0, 4.0)
    moved, *_ = change(jig_borer_lumps, "sensor_offset", inputs, error=-31.0)
    np.testing.assert_allclose(moved["T1"], -31.0, atol=1e-9)
    moved, *_ = change(jig_borer_lumps, "sensor_drift", inputs, rate=0.25)
    np.testing.assert_allclose(moved["T1"], 0.25 * inputs["time_s"] / 3600.0, atol=1e-9)
