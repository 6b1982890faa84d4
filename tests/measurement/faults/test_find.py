"""What is wrong with a set of runs."""

import numpy as np
import pandas as pd
import pytest

from measurement.faults import cleaned, faults_text, find_faults, looked_over, unusable
from measurement.runs import Run, read_run


def good_run(number: int, **changes: np.ndarray) -> Run:
    random = np.random.default_rng(number)
    time = np.arange(0.0, 4 * 3600.0, 60.0)
    warm = 8.0 * (1 - np.exp(-time / 3600.0))
    columns = {"time_s": time}
    for sensor in range(5):
        noise = 0.05 * random.standard_normal(len(time))
        columns[f"T{sensor + 1}_degC"] = 20.0 + number + (0.5 + 0.1 * sensor) * warm + noise
    columns["disp_z_um"] = 3.0 * warm + 0.05 * random.standard_normal(len(time))
    return Run(f"run{number}", pd.DataFrame(columns | changes))


GOOD = [good_run(number) for number in range(6)]


def changed(run: Run, column: str, values: np.ndarray) -> Run:
    return Run(run.name, run.frame.assign(**{column: values}))


def test_a_sensor_that_jumps_between_runs_is_named_in_each():
    later = [changed(run, "T3_degC", run.frame["T3_degC"].to_numpy() + 31.0) for run in GOOD[4:]]
    first, last = find_faults([*GOOD[:4], *later])
    assert (first.kind, first.column) == ("level_jump", "T3_degC")
    assert "reads +31 K compared with its level in the other runs" in first.text
    assert (first.run, last.run, first.place) == ("run4", "run5", 4)
    assert first.line().endswith("not used where absolute levels count; rises are not affected")
    assert "T3_degC, level_jump in run4, run5; " in faults_text([first, last])


def test_a_run_is_judged_alike_alone_and_among_others():
    odd = changed(GOOD[2], "T3_degC", GOOD[2].frame["T3_degC"].to_numpy() - 20.0)
    runs = looked_over([*GOOD[:2], odd, *GOOD[3:]])
    (fault,) = find_faults(runs[2:4])
    assert (fault.kind, fault.run, fault.place) == ("level_jump", "run2", 0)
    assert find_faults([runs[0]]) == []


def test_what_is_not_to_be_used_is_taken_out_and_nothing_else():
    values = GOOD[0].frame["T2_degC"].to_numpy().copy()
    values[100] += 30.0
    runs = [GOOD[1], changed(GOOD[0], "T2_degC", values)]
    left = cleaned(runs, find_faults(runs))
    assert left[0] is runs[0]
    assert np.flatnonzero(left[1].frame["T2_degC"].isna()).tolist() == [100]
    assert left[1].frame.drop(columns="T2_degC").notna().all(axis=None)


def test_a_staircase():
    values = np.floor(GOOD[0].frame["disp_z_um"].to_numpy() / 2.0) * 2.0
    found = find_faults([changed(GOOD[0], "disp_z_um", values), *GOOD[1:]])
    assert "staircase" in [fault.kind for fault in found]
    assert any("steps of 2 um" in fault.text for fault in found)


def test_missing_values_are_gathered_over_runs():
    holes = [
        changed(run, "T1_degC", run.frame["T1_degC"].mask(np.arange(240) // 30 == 3))
        for run in GOOD[:4]
    ]
    faults = find_faults([*holes, *GOOD[4:]])
    assert [fault.kind for fault in faults] == ["missing"] * 4
    assert [fault.run for fault in faults] == [run.name for run in holes]
    assert "missing 4 times" in faults_text(faults)


def test_a_sensor_that_is_read_rarely_misses_nothing():
    slow = changed(
        GOOD[0], "T1_degC", np.where(np.arange(240) % 10, np.nan, GOOD[0].frame["T1_degC"])
    )
    held = changed(
        GOOD[1], "T1_degC", GOOD[1].frame["T1_degC"].to_numpy()[np.arange(240) // 20 * 20]
    )
    assert find_faults([slow, held, *GOOD[2:]]) == []


def test_a_pause_of_the_record_is_no_missing_sample_of_a_slow_sensor():
    every_other = np.where(np.arange(240) % 2, np.nan, GOOD[0].frame["T1_degC"])
    frame = GOOD[0].frame.assign(T1_degC=every_other)
    paused = Run(GOOD[0].name, pd.concat([frame[:102], frame[160:]], ignore_index=True))
    kinds = [fault.kind for fault in find_faults([paused, *GOOD[1:]])]
    assert kinds == ["pause"]


@pytest.mark.long
@pytest.mark.real_data
def test_the_known_faults_of_the_lathe(lathe_runs):
    faults = find_faults([read_run(path) for path in lathe_runs])
    found: dict[tuple[str, str], list[str]] = {}
    for fault in faults:
        found.setdefault((fault.kind, fault.column), []).append(fault.run)
    assert found["runaway", "PT10_degC"] == ["20200821"]
    assert found["level_jump", "PT10_degC"] == [p.stem for p in lathe_runs if p.stem > "20200821"]
    assert found["saturated", "disp_z_um"] == ["20200706"]
    assert len(set(found["frozen", "disp_x_um"])) >= 15
    assert ("restart", "disp_x_um") in found
    assert ("staircase", "disp_x_um") in found
    # The drives' thermometers stopped after two hours of this run, while all others rose by 5 K.
    motors = {"spindle_motor_degC", "x_motor_degC", "z_motor_degC"}
    frozen = {(one.column, one.run) for one in unusable(faults) if one.column in motors}
    assert frozen == {(motor, "20200907") for motor in motors}
    thermometers = {column for _, column in found if column.endswith("degC")}
    assert thermometers == {"PT10_degC"} | motors


def test_runs_that_are_alike_to_the_last_digit_are_no_trouble():
    assert "nothing" in faults_text([])
    assert find_faults([Run(name, GOOD[0].frame) for name in "abc"]) == []
