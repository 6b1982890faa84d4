"""Broken sensors that must be seen, and sound ones that must not be called broken."""

import numpy as np
import pandas as pd
import pytest

from measurement.faults import GROSS, LEVELS, Fault, find_faults, unusable
from measurement.runs import FloatArray, Run, read_run

TIME = np.arange(0.0, 6 * 3600.0 + 1.0, 60.0)
MINUTE = TIME / 60.0


def run_of(seed: int, **changes: FloatArray) -> Run:
    """Return six hours of a machine that runs all the time, in a hall that warms."""
    random = np.random.default_rng(seed)
    warm = 1.0 - np.exp(-TIME / 5000.0)
    hall = 3.0 * TIME / TIME[-1]
    columns = {"time_s": TIME, "speed_rpm": np.full(len(TIME), 3000.0)}
    for sensor in range(1, 8):
        noise = 0.03 * random.standard_normal(len(TIME))
        columns[f"T{sensor}_degC"] = 20.0 + hall + sensor * warm + noise
    columns["disp_z_um"] = -30.0 * warm + 0.2 * random.standard_normal(len(TIME))
    return Run(f"run{seed}", pd.DataFrame(columns | changes))


SOUND = run_of(1)


def reading(column: str) -> FloatArray:
    return SOUND.frame[column].to_numpy().copy()


def broken(*others: Run, **changes: FloatArray) -> list[tuple[str, str, float, float]]:
    """Return kind, column, start and end [min] of what is called broken in a changed run."""
    faults: list[Fault] = find_faults([run_of(1, **changes), *others])
    return [
        (one.kind, one.column, one.start_s / 60.0, one.end_s / 60.0)
        for one in unusable(faults, (*GROSS, *LEVELS))
    ]


def from_minute(first: float, until: float, size: float) -> FloatArray:
    """Return what is added from a minute on and until another."""
    return np.where((first <= MINUTE) & (until > MINUTE), size, 0.0)


@pytest.mark.parametrize(
    ("column", "added", "kind", "start", "end"),
    [
        ("T3_degC", 30.0, "never_right", 0.0, 360.0),
        ("T3_degC", -30.0, "never_right", 0.0, 360.0),
        ("T2_degC", from_minute(0.0, 1.0, 5.0), "spikes", 0.0, 0.0),
        ("disp_z_um", from_minute(200.0, 201.0, -80.0), "spikes", 200.0, 200.0),
        ("disp_z_um", from_minute(360.0, 361.0, 50.0), "spikes", 360.0, 360.0),
        ("T2_degC", from_minute(100.0, 160.0, -20.0), "step", 100.0, 159.0),
        ("disp_z_um", from_minute(100.0, 160.0, 60.0), "step", 100.0, 159.0),
    ],
)
def test_what_is_off_is_bad_as_long_as_it_is(column, added, kind, start, end):
    assert broken(**{column: reading(column) + added}) == [(kind, column, start, end)]


def test_the_others_tell_that_a_coarse_sensor_froze():
    runs = [run_of(n, T5_degC=np.round(run_of(n).frame["T5_degC"])) for n in (2, 3)]
    values = np.round(reading("T5_degC"))
    assert broken(*runs, T5_degC=values) == []
    values[45:] = values[45]
    ((kind, column, start, end),) = broken(*runs, T5_degC=values)
    assert (kind, column, end) == ("frozen", "T5_degC", 360.0)
    assert start <= 45.0  # it showed this value for a while before


@pytest.mark.parametrize("level", [0.0, 85.0])
def test_a_thermometer_that_drops_to_a_constant_is_dead_even_at_a_switch(level):
    values = np.where(MINUTE >= 180.0, level, reading("T4_degC"))
    speed = np.where(MINUTE >= 180.0, 0.0, 3000.0)
    found = broken(T4_degC=values, speed_rpm=speed)
    assert found == [("dead", "T4_degC", 180.0, 360.0)]


def test_a_runaway_that_comes_back_is_bad_until_then():
    away = np.interp(MINUTE, [120.0, 140.0, 200.0, 220.0], [0.0, 25.0, 25.0, 0.0])
    ((kind, column, start, end),) = broken(T3_degC=reading("T3_degC") + away)
    assert (kind, column) == ("runaway", "T3_degC")
    assert start == pytest.approx(121.0, abs=3.0)
    assert end == pytest.approx(214.0, abs=4.0)


LOAD = 30.0 * (1.0 - np.exp(-np.clip(TIME - 7200.0, 0.0, None) / 1200.0))
ABOVE = {"T5_degC": 6.0, "T6_degC": 9.0, "T7_degC": 25.0}
NOT_BROKEN = {
    "nothing happens": {},
    "a load that nobody recorded warms a part and its neighbour": {
        "T6_degC": reading("T6_degC") + LOAD,
        "T7_degC": reading("T7_degC") + 0.4 * LOAD,
    },
    "a motor that still warms long after it was switched on": {
        "T7_degC": reading("T7_degC") + 80.0 * (1.0 - np.exp(-np.clip(TIME / 3600 - 1.0, 0, None))),
        "speed_rpm": np.where(MINUTE < 60.0, 0.0, 3000.0),
    },
    # Most thermometers sit near the coolant; two are warm, and the rear bearing is hot.
    "the hottest part of a record that begins warm": {
        f"T{n}_degC": 22.0 + 0.3 * n + 0.1 * np.sin(MINUTE / 9.0 + n) + ABOVE.get(f"T{n}_degC", 0.0)
        for n in range(1, 8)
    }
    | {"disp_z_um": np.round(np.sin(MINUTE / 40.0), 2)},
    # At rest in the first sample, running in the second: centrifugal force moves the shaft.
    "a first reading before a switch": {
        "disp_z_um": reading("disp_z_um") - np.where(TIME > 0.0, 0.0, 60.0),
        "speed_rpm": np.where(TIME > 0.0, 3000.0, 0.0),
    },
    # Parts of a running spindle spread widely: the hottest is far from the middle for good.
    "a machine that is warm from the first sample on": {
        f"T{n}_degC": reading(f"T{n}_degC") + 5.0 * (n - 1) for n in range(1, 8)
    },
}


@pytest.mark.parametrize("what", NOT_BROKEN)
def test_what_a_sound_machine_does_is_not_called_broken(what):
    assert broken(**NOT_BROKEN[what]) == []


def test_a_bearing_that_is_hot_in_one_run_alone_is_not_broken():
    hot = reading("T6_degC") + 25.0 * (1.0 - np.exp(-TIME / 1500.0))
    assert broken(*(run_of(n) for n in range(2, 6)), T6_degC=hot) == []


@pytest.mark.real_data
def test_the_electric_spindle_s_rear_bearing_is_hot_and_not_broken(electric_spindle_run):
    whole = read_run(electric_spindle_run)
    later = Run("later", whole.frame.iloc[1500:])
    for run in (whole, later):
        assert not [one.line() for one in find_faults([run]) if one.is_gross or one.kind in LEVELS]
