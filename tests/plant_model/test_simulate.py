"""Whole simulations: many sets at once, uneven rows, the studies' magnitudes."""

import numpy as np
import pandas as pd
import pytest
from hypothesis import given
from hypothesis import strategies as st

import plant_model.simulate as simulate_module
from plant_model.drive import DriveError, drive_from
from plant_model.machine_file import read_machine
from plant_model.parameters import ParameterError
from plant_model.simulate import simulate
from tests.plant_model.conftest import inputs_over

STEP_SPECTRUM = [4000, 6000, 8000, 10000, 12000, 9000, 12000, 12000]


@pytest.mark.parametrize("name", ["jig_borer", "jig_borer_lumps"])
def test_the_studies_magnitudes(name):
    time = np.arange(0.0, 8 * 3600.0 + 5.0, 10.0)
    speed = np.array(STEP_SPECTRUM, dtype=float)[np.minimum(time // 3600.0, 7).astype(int)]
    inlet = 21.0 + 3.2 * (1.0 - np.exp(-time / 6000.0))
    inputs = pd.DataFrame({"time_s": time, "speed_rpm": speed, "T5_degC": 21.0, "T9_degC": inlet})
    result = simulate(read_machine(name), inputs)
    end = {channel: float(series[0, -1]) for channel, series in result.readings.items()}
    temperatures = {channel: value for channel, value in end.items() if channel.startswith("T")}
    assert max(temperatures, key=lambda channel: temperatures[channel]) == "T1"
    assert end["T1"] == pytest.approx(30.4, abs=1.0)
    assert end["T11"] == pytest.approx(26.7, abs=1.0)
    for channel in ("T2", "T3", "T4", "T6", "T7", "T8", "T9", "T10"):
        assert end[channel] == pytest.approx(26.0, abs=2.1), channel
    elongation = -result.readings["S5"][0]
    assert elongation.max() == pytest.approx(40.0, abs=5.0)


@pytest.mark.parametrize("name", ["jig_borer", "jig_borer_lumps"])
def test_settling_takes_the_studies_hours(name):
    inputs = inputs_over(14.0, speed=12000.0, steps=False, every_s=60.0)
    inputs["T5_degC"] = 21.0
    inputs["T9_degC"] = 21.0 + 3.2 * (1.0 - np.exp(-inputs["time_s"] / 6000.0))
    elongation = -simulate(read_machine(name), inputs).readings["S5"][0]
    settled = np.flatnonzero(np.abs(elongation / elongation[-1] - 1.0) > 0.03)[-1]
    assert 200.0 < inputs["time_s"][settled] / 60.0 < 450.0


def test_sets_in_turns_equal_all_at_once(jig_borer_lumps, monkeypatch):
    inputs = inputs_over(0.2)
    sets = {"sources.motor.loss": np.linspace(16.0, 39.0, 5)}
    whole = simulate(jig_borer_lumps, inputs, sets)
    monkeypatch.setattr(simulate_module, "CHUNK_NUMBERS", 24 * 73 * 2)
    np.testing.assert_array_equal(simulate(jig_borer_lumps, inputs, sets).pose, whole.pose)


def test_uneven_rows_give_the_same_trajectory(jig_borer_lumps):
    inputs = inputs_over(2.0, every_s=10.0)
    chosen = np.random.default_rng(3).random(len(inputs)) < 0.4
    chosen |= (inputs["speed_rpm"].diff().fillna(1.0) != 0.0).to_numpy()
    chosen |= (inputs["speed_rpm"].diff().shift(-1).fillna(1.0) != 0.0).to_numpy()
    uneven = inputs[chosen].reset_index(drop=True)
    expected = simulate(jig_borer_lumps, inputs).run_frame()[chosen].reset_index(drop=True)
    got = simulate(jig_borer_lumps, uneven).run_frame()
    assert np.abs(expected["S5_um"] - got["S5_um"]).max() < 0.02
    assert np.abs(expected["T1_degC"] - got["T1_degC"]).max() < 0.02


def test_gaps_in_inputs_are_bridged(jig_borer_lumps):
    inputs = inputs_over(0.5)
    holed = inputs.copy()
    holed.loc[5:8, ["speed_rpm", "T5_degC"]] = np.nan
    expected, got = (simulate(jig_borer_lumps, frame).readings["S5"] for frame in (inputs, holed))
    np.testing.assert_allclose(got, expected, atol=0.05)


def test_nodes_start_at_the_sensor_that_the_file_names(jig_borer_lumps):
    inputs = inputs_over(0.1).assign(T1_degC=27.5, T2_degC=[np.nan] * 3 + [24.0] * 34)
    first = simulate(jig_borer_lumps, inputs).temperatures[0, 0]
    assert first[jig_borer_lumps.node_index["rear_outer"]] == 27.5
    assert first[jig_borer_lumps.node_index["pedestal"]] == 24.0
    assert first[jig_borer_lumps.node_index["housing_front_xm"]] == 21.0


def test_noise_has_the_stated_size_and_seed(jig_borer_lumps):
    inputs = inputs_over(4.0)
    exact = simulate(jig_borer_lumps, inputs).readings
    noisy = simulate(jig_borer_lumps, inputs, noise_seed=1).readings
    again = simulate(jig_borer_lumps, inputs, noise_seed=1).readings
    other = simulate(jig_borer_lumps, inputs, noise_seed=2).readings
    assert np.std(noisy["T1"] - exact["T1"]) == pytest.approx(0.03, rel=0.1)
    assert np.std(noisy["S1"] - exact["S1"]) == pytest.approx(0.2, rel=0.1)
    np.testing.assert_array_equal(noisy["T1"], again["T1"])
    assert not np.array_equal(noisy["T1"], other["T1"])
    np.testing.assert_allclose(np.round(noisy["S5"] * 10) / 10, noisy["S5"], atol=1e-9)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda f: f.drop(columns="speed_rpm"), "speed_rpm"),
        (lambda f: f.assign(T5_degC=np.nan), "T5_degC"),
        (lambda f: f.iloc[::-1], "ascend"),
        (lambda f: f.iloc[:1], "two rows"),
        (lambda f: f.drop(columns="time_s"), "time_s"),
        (
            lambda f: f.assign(time_s=f.time_s + 1.7e9 * (f.time_s > 60.0)),
            r"time_s: 1\.7e\+09 after",
        ),
        (lambda f: f.assign(speed_rpm="fast"), "speed_rpm: could not convert"),
    ],
)
def test_inputs_that_cannot_drive_are_refused(change, words, jig_borer_lumps):
    with pytest.raises(DriveError, match=words):
        simulate(jig_borer_lumps, change(inputs_over(0.1)))


@pytest.mark.parametrize(
    ("parameters", "words"),
    [
        ({"sources.motor.lost": 1.0}, "no parameter"),
        ({"sources.motor.loss": 1e6}, "outside"),
        ({"sources.motor.loss": np.nan}, "outside"),
        ({"sources.motor.loss": [20.0, 21.0], "sources.motor.rotor_share": [0.3] * 3}, "3 values"),
    ],
)
def test_parameters_that_cannot_be_are_refused(parameters, words, jig_borer_lumps):
    with pytest.raises(ParameterError, match=words):
        simulate(jig_borer_lumps, inputs_over(0.1), parameters)


@given(
    speeds=st.lists(st.floats(0.0, 20000.0), min_size=3, max_size=30), seed=st.integers(0, 2**16)
)
def test_held_inputs_keep_their_mean_on_the_grid(speeds, seed):
    machine = read_machine("jig_borer_lumps")
    time = np.cumsum(np.random.default_rng(seed).uniform(0.5, 40.0, len(speeds)))
    frame = pd.DataFrame({"time_s": time, "speed_rpm": speeds, "T5_degC": 20.0, "T9_degC": 20.0})
    drive = drive_from(machine, frame, 10.0)
    turned = np.sum(drive.held["speed"] * np.diff(drive.grid))
    assert turned == pytest.approx(np.sum(np.array(speeds)[:-1] * np.diff(time)), rel=1e-9)
