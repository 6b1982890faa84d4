"""The speed spectrum of a run."""

import math

import numpy as np
import pandas as pd
import pytest

from measurement.runs import Run
from measurement.spectrum import speed_spectrum


def steps(speed: list[float], name: str = "speed_rpm") -> list[tuple[float, float, str]]:
    time = 10.0 * np.arange(len(speed))
    spectrum = speed_spectrum(Run("r", pd.DataFrame({"time_s": time, name: speed})))
    assert math.fsum(part.duration_s for part in spectrum) == time[-1] - time[0]
    return [(part.speed_rpm, part.duration_s, part.state) for part in spectrum]


def test_steps_of_speed_with_their_durations():
    assert steps([0, 1000, 1000, 2000, 2000, 2000, 0, 0]) == [
        (0, 10, "stopped"),
        (1000, 20, "running"),
        (2000, 30, "running"),
        (0, 10, "stopped"),
    ]


def test_a_measured_speed_that_wavers_is_one_step():
    wavering = [1000.0, 1004.0, 996.0, 999.0, 0.3, -0.2, 0.1]
    assert [(round(speed), length) for speed, length, _ in steps(wavering)] == [(1000, 40), (0, 20)]


def test_a_missing_speed_holds_and_an_unknown_beginning_stays_unknown():
    first, second = steps([math.nan, math.nan, 500, math.nan, 500])
    assert math.isnan(first[0])
    assert first[1:] == (20, "unknown")
    assert second == (500, 20, "running")


@pytest.mark.parametrize("name", ["T1_degC", "speed_mm_min"])
def test_without_a_speed_all_is_unknown(name):
    assert [part[1:] for part in steps([0, 0, 0], name)] == [(20, "unknown")]


def test_the_only_column_in_rpm_is_the_speed_and_of_two_the_one_called_speed():
    assert steps([5, 5], "spindle_rpm") == [(5, 10, "running")]
    frame = pd.DataFrame({"time_s": [0.0, 1.0], "fan_rpm": [9.0, 9.0], "pump_rpm": [1.0, 1.0]})
    assert speed_spectrum(Run("r", frame))[0].state == "unknown"
    assert speed_spectrum(Run("r", frame.assign(speed_rpm=7.0)))[0].speed_rpm == 7.0
