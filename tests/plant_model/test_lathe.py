"""The shipped lathe: sensors of the measured runs, and a warm-up of about their size."""

import numpy as np
import pandas as pd
import pytest

from measurement.runs import read_run
from plant_model.machine import Machine
from plant_model.machine_file import read_machine
from plant_model.sensors import column_of, displacement_names
from plant_model.simulate import simulate


@pytest.fixture(scope="module")
def lathe() -> Machine:
    return read_machine("lathe")


def warmed(machine: Machine, speed: float, feed: float) -> pd.DataFrame:
    """Return five hours from cold in a hall of 20 degC."""
    time = np.arange(0.0, 5 * 3600.0 + 1.0, 60.0)
    columns = {"time_s": time, "speed_rpm": speed, "feed_mm_min": feed, "TC08_degC": 20.0}
    return simulate(machine, pd.DataFrame(columns)).run_frame()


def test_at_rest_in_a_steady_hall_nothing_happens(lathe):
    shown = warmed(lathe, 0.0, 0.0)
    assert np.ptp(shown.filter(regex="_degC$").to_numpy()) < 1e-9
    assert np.abs(shown[["disp_x_um", "disp_z_um"]].to_numpy()).max() < 1e-9


def test_it_warms_and_grows_about_as_measured(lathe):
    fast, slow = (warmed(lathe, speed, 5000.0).iloc[-1] for speed in (2000.0, 1000.0))
    # Warmest on the spindle, faster at 2000 r/min; feed axes do not care for the spindle's speed.
    assert 5.0 < slow["PT03_degC"] - 20.0 < fast["PT03_degC"] - 20.0 < 25.0
    assert 1.0 < fast["PT12_degC"] - 20.0 < 10.0
    assert abs(fast["PT09_degC"] - slow["PT09_degC"]) < 1.0
    assert 5.0 < fast["PT09_degC"] - 20.0 < 20.0
    # The spindle grows out of the headstock, and the bed takes part of it back.
    z = warmed(lathe, 2000.0, 5000.0)["disp_z_um"]
    assert -70.0 < z.min() < -10.0


def test_x_falls_within_the_hour_and_rises_for_the_rest_of_the_day(lathe):
    x = warmed(lathe, 2000.0, 5000.0).set_index("time_s")["disp_x_um"]
    # As measured: lowest after about an hour, by 9 to 20 um, and 20 to 35 um up at the end.
    assert -25.0 < x.min() < -5.0
    assert 30.0 < x.idxmin() / 60.0 < 100.0
    assert 15.0 < x.iloc[-1] < 45.0


@pytest.mark.real_data
def test_the_measured_runs_have_its_columns(lathe, lathe_runs):
    names = [sensor.name for sensor in lathe.sensors] + displacement_names(lathe)
    wanted = {column_of(lathe, name) for name in names} | {e.column for e in lathe.inputs}
    for path in (lathe_runs[0], lathe_runs[-1]):
        assert wanted <= set(read_run(path).frame.columns)
