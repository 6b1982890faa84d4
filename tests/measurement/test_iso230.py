"""The ISO 230-3 style summary."""

import json
import math
from dataclasses import asdict
from typing import Any

import numpy as np
import pandas as pd
import pytest

from measurement.errors import BadInput
from measurement.faults import cleaned, find_faults
from measurement.iso230 import Ranges, summarise
from measurement.rig import FivePointRig, default_rig
from measurement.runs import Run, read_run
from tests.refusing import refusal

RIG = FivePointRig(spacing_mm=100.0, near_to_gauge_mm=30.0)
HOUR = 3600.0


def standard_test(**changes: Any) -> Run:
    """Return 30 min of standing, 4 h of running and 1 h of standing, every minute."""
    time = np.arange(0.0, 5.5 * HOUR + 1, 60.0)
    on = np.clip(time - 1800.0, 0.0, 4 * HOUR) / HOUR  # hours run
    columns = {
        "time_s": time,
        "speed_rpm": np.where((time >= 1800.0) & (time < 4.5 * HOUR), 6000.0, 0.0),
        "T1_degC": 20.0 + 2.0 * on,
        "T5_degC": 21.0 - time / (5.5 * HOUR),
        "S1_um": 1.0 * on,
        "S2_um": 1.0 * on,
        "S3_um": 3.0 * on,
        "S4_um": -3.0 * on,
        "S5_um": -10.0 * on,
    }
    return Run("standard", pd.DataFrame(columns | changes))


def values(ranges: Ranges) -> list[float]:
    return list(asdict(ranges).values())


def test_ranges_of_a_known_run():
    summary = summarise(standard_test(), RIG, "T5_degC")
    assert summary.test == "thermal distortion caused by rotating spindle"
    assert summary.is_standard_spindle_test
    assert (summary.running_s, summary.stopped_s, summary.unknown_s) == (4 * HOUR, 1.5 * HOUR, 0)
    assert summary.running_period_s == (1800.0, 4.5 * HOUR)
    # 10 um/h: in the first 60 min from the start, while running, over the whole, and net
    assert values(summary.displacements["S5_um"]) == pytest.approx([10, 40, 40, -40])
    assert values(summary.pose["elongation_um"]) == pytest.approx([10, 40, 40, 40])
    # (3 - 1) um/h over 100 mm is 20 urad/h
    assert values(summary.pose["yaw_urad"]) == pytest.approx([20, 80, 80, 80], rel=1e-6)
    assert values(summary.pose["pitch_urad"]) == pytest.approx([40, 160, 160, -160], rel=1e-6)
    assert summary.spacing_mm == 100.0
    assert summary.places["S3_um"] == "distal, X"
    assert asdict(summary.temperatures["T1_degC"]) == pytest.approx(
        {"start": 20, "highest": 28, "rise": 8, "last": 28}
    )
    assert summary.ambient.drift == pytest.approx(-1.0)
    assert summary.ambient.range == pytest.approx(1.0)
    assert not summary.findings


def test_cooling_down_counts_in_the_whole_but_not_in_the_running_period():
    run = standard_test()
    after = run.time_s > 4.5 * HOUR
    run = standard_test(S5_um=np.where(after, 15.0, run.frame["S5_um"]))
    assert values(summarise(run).displacements["S5_um"]) == pytest.approx([10, 40, 55, -40])


@pytest.mark.parametrize(
    ("speed", "feed", "test"),
    [
        (0.0, None, "environmental temperature variation error (ETVE)"),
        (0.0, 0.0, "environmental temperature variation error (ETVE)"),
        (0.0, 5000.0, "thermal distortion caused by moving linear axes"),
        (None, 5000.0, "thermal distortion caused by moving linear axes"),
        (100.0, 0.0, "thermal distortion caused by rotating spindle"),
        (100.0, 5000.0, "thermal distortion caused by rotating spindle, with linear axes moving"),
        (None, None, "not known: no spindle speed was recorded"),
    ],
)
def test_which_test_of_the_standard_a_run_is(speed, feed, test):
    columns = {"speed_rpm": speed, "feed_mm_min": feed}
    given = {name: [value] * 3 for name, value in columns.items() if value is not None}
    summary = summarise(Run("r", pd.DataFrame({"time_s": [0.0, 60.0, 120.0]} | given)))
    assert summary.test == test
    assert not summary.is_standard_spindle_test
    assert (summary.running_period_s is not None) == bool(speed)


@pytest.mark.parametrize(
    ("minutes", "is_standard"),
    [
        ((200, 10, 30, 60), True),
        ((10, 300, 10, 60), False),
        ((240, 60, 10, 0), True),
        ((200, 60, 40, 60), False),
    ],
)
def test_an_hour_of_standing_ends_the_running(minutes, is_standard):
    speed = np.repeat([6000.0, 0.0, 6000.0, 0.0], minutes)
    run = Run("r", pd.DataFrame({"time_s": 60.0 * np.arange(len(speed)), "speed_rpm": speed}))
    assert summarise(run).is_standard_spindle_test == is_standard


def test_only_what_a_run_has_is_stated():
    bare = summarise(Run("bare", pd.DataFrame({"time_s": [5.0]})))
    assert (bare.displacements, bare.pose, bare.temperatures, bare.ambient) == ({}, {}, {}, None)
    assert math.isnan(bare.interval_s)
    assert "Range of" not in bare.text()
    json.dumps(bare.to_dict(), allow_nan=False)
    empty = summarise(Run("r", pd.DataFrame({"time_s": [0.0, 1.0], "a_um": [math.nan] * 2})))
    assert all(math.isnan(value) for value in values(empty.displacements["a_um"]))
    assert empty.to_dict()["displacements"]["a_um"]["whole"] is None


def test_a_column_of_the_rig_that_the_run_has_not_is_named():
    run = Run("r", standard_test().frame.drop(columns="S5_um"))
    summary = summarise(run, RIG)
    assert not summary.pose
    assert [(f.kind, f.column) for f in summary.findings] == [("absent", "S5_um")]
    assert summary.places["S1_um"] == "near, X"


@pytest.mark.parametrize(
    ("column", "problem"),
    [("T99_degC", "no column 'T99_degC'; its temperatures: T1"), ("S1_um", "is not a temperature")],
)
def test_a_wrong_ambient_column_is_refused(column, problem):
    with pytest.raises(BadInput, match=f"standard: ambient: .*{problem}"):
        summarise(standard_test(), ambient=column)
    blank = standard_test(T5_degC=np.nan)
    assert "holds no value" in refusal(summarise, blank, ambient="T5_degC")


@pytest.mark.long
@pytest.mark.real_data
def test_every_measured_run_has_a_summary(lathe_runs, electric_spindle_run):
    for path in [*lathe_runs, electric_spindle_run]:
        run = read_run(path)
        summary = summarise(run, default_rig(run))
        assert json.loads(json.dumps(summary.to_dict(), allow_nan=False))["samples"] == len(
            run.frame
        )
        assert run.name in summary.text()
        parts = (summary.running_s, summary.stopped_s, summary.unknown_s)
        assert math.fsum(parts) == pytest.approx(summary.duration_s)
        for name in run.displacements:
            ranges = summary.displacements[name]
            left = cleaned([run], find_faults([run]))[0].frame[name]
            assert ranges.whole == left.max() - left.min()


@pytest.mark.real_data
def test_the_schedule_of_a_measured_run_is_found(lathe_runs):
    run = read_run(next(path for path in lathe_runs if path.stem == "20200723"))
    spectrum = [
        (round(part.speed_rpm), round(part.duration_s / HOUR, 1))
        for part in summarise(run).segments
    ]
    assert spectrum[:3] == [(1200, 2.5), (0, 1.0), (1800, 2.5)]  # as its publisher's schedule says
    assert spectrum[3:] == [(0, 0.0)]  # the last samples, after the schedule's end


def test_the_text_says_what_a_report_states():
    text = summarise(standard_test(), RIG, "T5_degC").text()
    assert "rotating spindle" in text
    assert "sensor spacing of 100 mm" in text
    assert "T5_degC" in text
    row = next(line for line in text.splitlines() if line.startswith("  S5 (axial)"))
    assert row.split()[2:] == ["um", "10.0", "40.0", "40.0", "-40.0"]
    assert max(map(len, text.splitlines())) <= 100


def test_a_long_spectrum_is_cut_in_the_text_only():
    speed = np.arange(40) % 2 * 1000.0
    run = Run("r", pd.DataFrame({"time_s": np.arange(40) * 60.0, "speed_rpm": speed}))
    summary = summarise(run)
    assert "and 9 more" in summary.text()
    assert len(summary.to_dict()["segments"]) == len(summary.segments) == 39
