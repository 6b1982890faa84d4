"""Single channels that are grossly wrong, and real effects that must not be taken for it."""

import numpy as np
import pandas as pd
import pytest

from measurement.faults import GROSS, LEVELS, find_faults, unusable
from measurement.runs import FloatArray, Run

TIME = np.arange(0.0, 5 * 3600.0, 60.0)
STARTED, STOPPED = 1800.0, 12600.0


def run_of(number: int, **changes: FloatArray) -> Run:
    """Return a machine that warms from half an hour on and cools after three and a half."""
    random = np.random.default_rng(number)
    on = np.clip(TIME - STARTED, 0.0, STOPPED - STARTED)
    off = np.clip(TIME - STOPPED, 0.0, None)
    warm = (1.0 - np.exp(-on / 2400.0)) * np.exp(-off / 3000.0)
    columns = {
        "time_s": TIME,
        "speed_rpm": np.where((TIME >= STARTED) & (TIME < STOPPED), 2000.0 + 500.0 * number, 0.0),
    }
    for sensor in range(1, 7):
        noise = np.round(0.03 * random.standard_normal(len(TIME)), 2)
        columns[f"T{sensor}_degC"] = 20.0 + 2.0 * sensor * warm + noise
    columns["disp_x_um"] = 20.0 * warm + 0.2 * random.standard_normal(len(TIME))
    columns["disp_z_um"] = -30.0 * warm + 0.2 * random.standard_normal(len(TIME))
    # The centrifugal shift and a slip of a floating bearing are real, though they leap.
    columns["disp_z_um"] += np.where(columns["speed_rpm"] > 0.0, 30.0, 0.0)
    columns["disp_z_um"] += np.where(TIME > 9000.0, 15.0, 0.0)
    return Run(f"run{number}", pd.DataFrame(columns | changes))


GOOD = [run_of(number) for number in range(4)]


def broken(column: str, change: FloatArray | dict[int, float]) -> list[Run]:
    """Return the good runs with the second one changed: readings added, by row or all."""
    values = GOOD[1].frame[column].to_numpy().copy()
    if isinstance(change, dict):
        for row, value in change.items():
            values[row] += value
    else:
        values = values + change
    return [GOOD[0], run_of(1, **{column: values}), *GOOD[2:]]


@pytest.mark.parametrize("every", [1, 2, 4])
def test_good_runs_keep_everything_however_coarsely_they_are_sampled(every):
    coarse = [Run(run.name, run.frame.iloc[::every]) for run in GOOD]
    assert unusable(find_faults(coarse)) == []


SLIPS = np.where(TIME >= 120 * 60.0, 1.0, 0.0)
JUMPS = {int(row): 30.0 for row in np.random.default_rng(5).choice(np.arange(40, 200), 30, False)}


@pytest.mark.parametrize(
    ("column", "change", "kind", "start"),
    [
        ("T3_degC", JUMPS, "spikes", 0.0),
        ("T3_degC", 4.0 * SLIPS, "step", 120.0),
        ("disp_x_um", -60.0 * SLIPS, "step", 120.0),
        ("disp_z_um", 45.0 * SLIPS, "step", 120.0),
    ],
)
def test_a_probe_that_slips_is_bad_from_there_on_and_one_that_jumps_about_altogether(
    column, change, kind, start
):
    (fault,) = unusable(find_faults(broken(column, change)), (*GROSS, *LEVELS))
    assert (fault.kind, fault.run, fault.column) == (kind, "run1", column)
    assert (fault.start_s / 60.0, fault.end_s / 60.0) == (start, 299.0)


@pytest.mark.parametrize("error", [3.0, -3.0])
def test_small_errors_and_drifts_are_left_for_physics(error):
    for change in (np.full(len(TIME), error), error * TIME / TIME[-1]):
        assert unusable(find_faults(broken("T3_degC", change))) == []


@pytest.mark.parametrize(
    ("order", "bad"), [((0, 1, 2, 3), (2, 3)), ((0, 1, 2, 3), (1, 2, 3)), ((3, 1, 0, 2), (0,))]
)
def test_the_wrong_level_is_the_one_far_from_all_others(order, bad):
    runs = [
        run_of(n, T3_degC=GOOD[n].frame["T3_degC"].to_numpy() + (31.0 if n in bad else 0.0))
        for n in order
    ]
    found = {(fault.kind, fault.run) for fault in find_faults(runs)}
    assert found == {("level_jump", f"run{n}") for n in bad}
