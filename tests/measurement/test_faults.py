"""What is wrong with a set of runs."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from measurement.faults import faults_text, find_faults
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


def kinds(runs: list[Run]) -> dict[str, list[str]]:
    found: dict[str, list[str]] = {}
    for fault in find_faults(runs):
        found.setdefault(fault.kind, []).append(fault.column)
    return found


def changed(run: Run, column: str, values: np.ndarray) -> Run:
    return Run(run.name, run.frame.assign(**{column: values}))


def test_good_runs_have_no_faults() -> None:
    assert find_faults(GOOD) == []
    assert "nothing" in faults_text([])


def test_a_sensor_that_jumps_between_runs_is_named_with_the_day() -> None:
    later = [changed(run, "T3_degC", run.frame["T3_degC"].to_numpy() + 31.0) for run in GOOD[4:]]
    (fault,) = find_faults([*GOOD[:4], *later])
    assert (fault.kind, fault.column) == ("level_jump", "T3_degC")
    assert "31 K high from run4 on" in fault.text
    assert fault.runs == ("run4", "run5")
    assert fault.to_dict()["runs"] == ["run4", "run5"]


def test_one_odd_run_among_good_ones() -> None:
    odd = changed(GOOD[2], "T3_degC", GOOD[2].frame["T3_degC"].to_numpy() - 20.0)
    (fault,) = find_faults([*GOOD[:2], odd, *GOOD[3:]])
    assert fault.kind == "level_jump"
    assert fault.runs == ("run2",)


def test_a_sensor_that_leaves_the_others_within_a_run() -> None:
    values = GOOD[1].frame["T2_degC"].to_numpy().copy()
    values[120:] += 25.0
    found = kinds([GOOD[0], changed(GOOD[1], "T2_degC", values), *GOOD[2:]])
    assert "T2_degC" in found["stray"]


def test_frozen_displacement_and_its_jump_at_the_restart() -> None:
    values = GOOD[0].frame["disp_z_um"].to_numpy().copy()
    values[15:90] = values[15]
    found = find_faults([changed(GOOD[0], "disp_z_um", values), *GOOD[1:]])
    assert [fault.kind for fault in found] == ["frozen", "restart"]
    step = np.median(values[90:95]) - values[15]
    assert f"{step:+.0f} um" in found[1].text


def test_saturation_is_told_from_freezing() -> None:
    values = GOOD[0].frame["disp_z_um"].to_numpy().copy()
    values[15:] = 100.0
    assert kinds([changed(GOOD[0], "disp_z_um", values), *GOOD[1:]])["saturated"] == ["disp_z_um"]


def test_a_staircase() -> None:
    values = np.floor(GOOD[0].frame["disp_z_um"].to_numpy() / 2.0) * 2.0
    found = find_faults([changed(GOOD[0], "disp_z_um", values), *GOOD[1:]])
    assert "staircase" in [fault.kind for fault in found]
    assert any("steps of 2 um" in fault.text for fault in found)


def test_missing_values_are_gathered_over_runs() -> None:
    holes = [
        changed(run, "T1_degC", np.where(np.arange(240) % 3, run.frame["T1_degC"], np.nan))
        for run in GOOD[:4]
    ]
    (fault,) = find_faults([*holes, *GOOD[4:]])
    assert fault.kind == "missing"
    assert fault.runs == tuple(run.name for run in holes)


@pytest.mark.real_data
def test_the_known_faults_of_the_lathe(lathe_runs: list[Path]) -> None:
    faults = find_faults([read_run(path) for path in lathe_runs])
    texts = {(fault.kind, fault.column): fault for fault in faults}
    assert "31 K high from 20200821 on" in texts["level_jump", "PT10_degC"].text
    assert texts["saturated", "disp_z_um"].runs == ("20200706",)
    assert len(texts["frozen", "disp_x_um"].runs) >= 15
    assert ("restart", "disp_x_um") in texts
    assert ("staircase", "disp_x_um") in texts
    assert [column for kind, column in texts if kind in ("level_jump", "stray")] == [
        "PT10_degC",
        "PT10_degC",
    ]
