"""Data that looks wrong is said to."""

import math

import numpy as np
import pandas as pd
import pytest

from measurement.faults import GROSS, Fault, find_faults, unusable
from measurement.runs import Run, read_run

MINUTES = 300
RANDOM = np.random.default_rng(5)
NOISE = RANDOM.normal(0.0, 0.1, (3, MINUTES))
TIME = 60.0 * np.arange(MINUTES)
GROWTH = 30.0 * (1.0 - np.exp(-TIME / 6000.0))

TOLD = (*GROSS, "missing", "pause")


def found(frame: pd.DataFrame) -> list[tuple[str, str]]:
    return [(one.kind, one.column) for one in find_faults([Run("r", frame)]) if one.kind in TOLD]


def warm_up(**changes: object) -> pd.DataFrame:
    columns = {
        "time_s": TIME,
        "speed_rpm": np.full(MINUTES, 1000.0),
        "T1_degC": 20.0 + GROWTH / 2 + NOISE[0],
        "T2_degC": 20.0 + GROWTH / 3 + NOISE[0],
        "S1_um": GROWTH + NOISE[1],
        "S2_um": -GROWTH + NOISE[2],
    }
    return pd.DataFrame(columns | changes)


def test_a_channel_that_freezes_while_others_go_on():
    frozen = warm_up()["S1_um"].to_numpy().copy()
    frozen[30:60] = frozen[30]
    finding, back = find_faults([Run("r", warm_up(S1_um=frozen))])
    assert (back.kind, back.start_s) == ("restart", 60 * 60.0)
    assert back.text == "jumps by +6 um on coming back"
    assert (finding.kind, finding.column) == ("frozen", "S1_um")
    assert (finding.start_s, finding.end_s) == (1800.0, 59 * 60.0)
    assert finding.text.startswith(f"exactly {frozen[30]:g} um while T1")
    assert finding.line().startswith("r, S1_um, 30 to 59 min: exactly")
    assert finding.line().endswith("; this part of the channel is left out")


def test_other_displacements_tell_too_where_there_are_no_temperatures():
    frame = warm_up(S1_um=0.0).drop(columns=["T1_degC", "T2_degC"])
    (finding,) = find_faults([Run("r", frame)])
    assert (finding.kind, finding.column) == ("frozen", "S1_um")
    assert "while S2 moved by" in finding.text


def test_a_channel_at_rest_with_all_others_is_not_frozen():
    still = {name: np.full(MINUTES, 20.0) for name in ("T1_degC", "T2_degC", "S1_um", "S2_um")}
    assert found(warm_up(**still)) == []


def test_a_drift_that_runs_into_the_end_of_the_range_is_saturated():
    clipped = np.minimum(GROWTH + NOISE[1], 20.0)
    assert found(warm_up(S1_um=clipped)) == [("saturated", "S1_um")]
    assert found(warm_up(S2_um=-clipped)) == [("saturated", "S2_um")]


def test_a_channel_that_freezes_in_a_stop_is_at_its_extreme_by_chance():
    frame = warm_up()
    stopped = np.arange(MINUTES) >= 200
    cooling = frame["T1_degC"][200] - (TIME - TIME[200]) / 600.0
    temperature = np.where(stopped, cooling, frame["T1_degC"])
    growth = np.where(stopped, 60.0, 0.25 * np.arange(MINUTES))
    frame = warm_up(speed_rpm=np.where(stopped, 0.0, 1000.0), T1_degC=temperature, S1_um=growth)
    assert found(frame) == [("frozen", "S1_um")]


def test_gaps_that_are_not_bridged_are_said():
    holed = warm_up()["T1_degC"].to_numpy().copy()
    holed[:3] = np.nan
    assert found(warm_up(T1_degC=holed)) == []
    holed[:30] = np.nan
    (finding,) = find_faults([Run("r", warm_up(T1_degC=holed))])
    assert finding == Fault(
        "r", "T1_degC", "missing", 0.0, 29 * 60.0, "10.0% of the samples are missing"
    )
    assert found(warm_up(S1_um=math.nan)) == [("missing", "S1_um")]
    assert found(warm_up(T1_degC=math.nan)) == [("missing", "T1_degC")]


def test_only_holes_in_a_channel_that_is_read_rarely_are_missing():
    every_second = np.where(np.arange(MINUTES) % 2 == 0, warm_up()["S1_um"], math.nan)
    later = TIME + np.where(np.arange(MINUTES) >= 100, 3600.0, 0.0)
    paused = TIME + np.where(np.arange(MINUTES) >= 101, 3600.0, 0.0)
    for time in (later, paused):
        assert found(warm_up(time_s=time, S1_um=every_second)) == [("pause", "time_s")]
    failed = np.where(np.arange(MINUTES) == 100, math.nan, warm_up()["T1_degC"])
    assert found(warm_up(time_s=later, T1_degC=failed)) == [("pause", "time_s")]
    every_second[100:130] = math.nan
    (finding,) = find_faults([Run("r", warm_up(S1_um=every_second))])
    assert (finding.start_s, finding.end_s) == (99 * 60.0, 129 * 60.0)
    assert finding.text == "10.3% of the samples are missing"


def test_pauses_of_the_record_are_counted():
    time = TIME + np.where(np.arange(MINUTES) >= 100, 600.0, 0.0)
    time += np.where(np.arange(MINUTES) >= 200, 1200.0, 0.0)
    (finding,) = find_faults([Run("r", warm_up(time_s=time))])
    assert (finding.kind, finding.column) == ("pause", "time_s")
    assert finding.text.startswith("2 pauses")
    assert "longest of 21.0 min" in finding.text
    assert finding.start_s == 209 * 60.0


def test_all_temperatures_jumping_at_once_is_a_seam():
    later = np.arange(MINUTES) >= 150
    frame = warm_up()
    jumped = {name: frame[name] + np.where(later, 5.0, 0.0) for name in ("T1_degC", "T2_degC")}
    (finding,) = find_faults([Run("r", warm_up(**jumped))])
    assert (finding.kind, finding.start_s) == ("jump", 150 * 60.0)
    time = TIME + np.where(later, 7200.0, 0.0)
    assert found(warm_up(time_s=time, **jumped)) == [("pause", "time_s")]  # heat had time to flow


@pytest.mark.long
@pytest.mark.real_data
def test_the_known_faults_of_the_measured_runs(lathe_runs, electric_spindle_run):
    findings = {path.stem: unusable(find_faults([read_run(path)])) for path in lathe_runs}
    saturated = {
        (run, f.column) for run, fs in findings.items() for f in fs if f.kind == "saturated"
    }
    assert saturated == {("20200706", "disp_z_um")}
    assert [run for run, fs in findings.items() if any(f.kind == "jump" for f in fs)] == [
        "20200706"
    ]
    # In the stop in the middle both displacements are frozen.
    for run in ("20200723", "20200923", "20200928", "20200929", "20201005"):
        assert [(f.kind, f.column) for f in findings[run]] == [
            ("frozen", "disp_x_um"),
            ("frozen", "disp_z_um"),
        ]
        assert all(140 * 60 < f.start_s < 155 * 60 for f in findings[run])
    # These ran until the end of the record, and nothing stood still.
    assert findings["20200615"] == findings["20200813"] == findings["20200817"] == []
    # Steps of 0.25 um and no more drift: at rest, not frozen.
    assert unusable(find_faults([read_run(electric_spindle_run)])) == []


def test_a_short_standstill_and_an_offset_that_is_not_sent_are_no_findings():
    short = warm_up()["S1_um"].to_numpy().copy()
    short[30:45] = short[30]  # 14 min
    assert found(warm_up(S1_um=short)) == []
    assert found(warm_up(offset_X_um=0.0)) == []


def test_missing_samples_within_a_standstill_do_not_hide_it():
    frozen = warm_up()["S1_um"].to_numpy().copy()
    frozen[30:60] = frozen[30]
    frozen[40:42] = np.nan
    assert found(warm_up(S1_um=frozen)) == [("frozen", "S1_um")]
