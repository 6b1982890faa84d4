"""Runs onto an even grid: averaged, interpolated or held, with gaps left open."""

import math

import numpy as np
import numpy.testing as npt
import pandas as pd
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import quad

from measurement.resampling import resample
from measurement.runs import Run, read_run


def uneven(seed: int, samples: int = 200) -> np.ndarray:
    return np.cumsum(np.random.default_rng(seed).uniform(5.0, 45.0, samples))


@given(
    seed=st.integers(0, 1000),
    slope=st.floats(-1, 1),
    level=st.floats(-100, 300),
    step=st.floats(1.0, 2000.0),
)
def test_a_straight_line_stays_exact_at_any_step(seed, slope, level, step):
    time = uneven(seed)
    grid = np.arange(time[0], time[-1], step)
    at = resample(time, level + slope * time, grid, step)
    npt.assert_allclose(at, level + slope * grid, rtol=0, atol=1e-8)


def test_the_average_is_the_mean_of_the_interpolant_by_quadrature():
    time = uneven(1, 40)
    values = np.random.default_rng(2).normal(300.0, 5.0, time.size)
    grid = np.array([200.0, 400.0, 613.7])
    at = resample(time, values, grid, 120.0)
    for where, value in zip(grid, at, strict=True):
        knots = time[(time > where - 60) & (time < where + 60)].tolist()
        area, _ = quad(
            lambda t: float(np.interp(t, time, values)), where - 60, where + 60, points=knots
        )
        assert value == pytest.approx(area / 120.0, abs=1e-9)


def test_speed_holds_and_temperature_runs_smoothly():
    frame = pd.DataFrame(
        {"time_s": [0.0, 10.0, 20.0], "speed_rpm": [0.0, 500.0, 0.0], "T1_degC": [20.0, 22.0, 26.0]}
    )
    fine = Run("r", frame).resampled(5.0).frame
    assert fine["time_s"].tolist() == [0, 5, 10, 15, 20]
    assert fine["speed_rpm"].tolist() == [0, 0, 500, 500, 0]
    assert fine["T1_degC"].tolist() == [20, 21, 22, 24, 26]


def test_gaps_longer_than_the_limit_stay_open_and_shorter_ones_close():
    time = np.arange(0.0, 200.0, 10.0)
    values = time.copy()
    values[5:9] = np.nan  # 40 s .. 90 s
    grid = np.arange(0.0, 191.0, 5.0)
    npt.assert_allclose(resample(time, values, grid, 5.0), grid)  # 50 s is five intervals, no more
    values[9] = np.nan  # and 60 s is six
    open_at = (grid > 40.0) & (grid < 100.0)
    limited = resample(time, values, grid, 5.0)
    assert np.isnan(limited[open_at]).all()
    npt.assert_allclose(limited[~open_at], grid[~open_at])
    held = resample(time, values, grid, 5.0, holds=True)
    assert np.isnan(held[(grid > 90.0) & (grid < 100.0)]).all()
    assert (held[(grid >= 40.0) & (grid <= 90.0)] == 40.0).all()
    assert held[-1] == 190.0


def test_nothing_is_made_up_before_the_first_or_after_the_last_sample():
    time = np.array([10.0, 20.0])
    grid = np.array([0.0, 10.0, 20.0, 30.0])
    at = resample(time, np.array([1.0, 2.0]), grid, 10.0)
    npt.assert_array_equal(at, [np.nan, 1.0, 2.0, np.nan])
    assert np.isnan(resample(time, np.array([np.nan, np.nan]), grid, 10.0)).all()
    single = resample(np.array([10.0]), np.array([3.0]), grid, 10.0)
    npt.assert_array_equal(single, [np.nan, 3.0, np.nan, np.nan])


def test_the_grid_covers_the_run():
    run = Run("r", pd.DataFrame({"time_s": [0.0, 0.7], "a_um": [0.0, 7.0]}))
    # In binary 0.7/0.1 falls just short of 7, and 7 * 0.1 lies just beyond 0.7.
    npt.assert_allclose(run.resampled(0.1).frame["a_um"], np.arange(8.0), atol=1e-12)


@pytest.mark.parametrize("step", [0.0, -1.0, math.nan, math.inf, 1e-9])
def test_a_senseless_step_is_refused(step):
    run = Run("r", pd.DataFrame({"time_s": [0.0, 100.0]}))
    with pytest.raises(ValueError, match="step_s"):
        run.resampled(step)


@pytest.mark.long
@pytest.mark.real_data
def test_measured_runs_have_no_holes_at_any_usual_step(lathe_runs):
    for path in lathe_runs:
        run = read_run(path)
        for step in (1.0, 60.0):
            frame = run.resampled(step).frame
            assert not frame.isna().any().any()
            assert (frame.max() <= run.frame.max() + 1e-9).all()
            assert (frame.min() >= run.frame.min() - 1e-9).all()
