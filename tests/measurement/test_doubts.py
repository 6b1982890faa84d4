"""What the numbers contradict is doubted, and what is as it should be is not."""

from collections.abc import Callable

import numpy as np
import pandas as pd
import pytest

from measurement.doubts import doubt_lines, doubts
from measurement.doubts.clock import rows_after
from measurement.doubts.places import swapped
from measurement.doubts.signs import flipped
from measurement.importing.log import Imported
from measurement.runs import Run, read_run
from tests.measurement.importing.made import HEADER, ROWS, elapsed, signals, table
from tests.measurement.lab import clock_s, day

NAMES = np.array(["Temp_Lager_vorn_degC", "T_hinten_degC", "Halle_degC", "speed_rpm", "z_um"])


@pytest.fixture
def doubted(log: Callable[..., Imported]) -> Callable[..., dict[str, str]]:
    """Returns what is doubted in a log of these values."""
    return lambda values, header=HEADER: dict(log(table(header=header, values=values)).doubts)


@pytest.mark.parametrize(
    ("columns", "factor", "offset", "told"),
    [
        ([], 1.0, 0.0, "nothing"),
        ([0], 1.0, 273.15, "kelvin"),
        ([0, 1, 2], 1.0, 273.15, "kelvin"),
        ([1, 2], 1.8, 32.0, "Fahrenheit"),
        ([0, 1, 2], 1.8, 32.0, "Fahrenheit"),
        ([0, 1, 2], 10.0, 0.0, "then its unit is 0.1 degC"),
        ([1], 10.0, 0.0, "then its unit is 0.1 degC"),
        ([3], 1e-3, 0.0, "krpm"),
        ([4], 1e-3, 0.0, "millimetres taken for micrometres? then its unit is mm"),
    ],
)
def test_columns_in_another_unit(columns, factor, offset, told, doubted):
    values = signals()
    values[:, columns] = values[:, columns] * factor + offset
    if factor == 10.0:
        values[:, columns] = values[:, columns].round()
    found = doubted(values)
    assert set(found) == set(NAMES[columns])
    assert all(told in text for text in found.values())


def test_a_speed_in_turns_a_second_is_doubted_in_the_runs_that_have_it():
    runs = [run_of_day(number) for number in (1, 2, 3)]
    speeds = (6000.0, 100.0, 100.0)
    right, *wrong = [
        Run(run.name, run.frame.assign(speed_rpm=speed))
        for run, speed in zip(runs, speeds, strict=True)
    ]
    ((column, text),) = doubts([right, *wrong])
    assert column == "speed_rpm"
    assert text.endswith("turns a second? then its unit is Hz (in day2, day3)")


def test_columns_that_are_doubted_alike_share_a_line():
    runs = [run_of_day(number) for number in (1, 2, 3)]
    hot = [name for name in runs[0].frame if name.endswith("_degC")]
    wrong = [
        Run(run.name, run.frame.assign(**{n: 1.8 * run.frame[n] + 32 for n in hot})) for run in runs
    ]
    (line,) = doubt_lines(wrong)
    assert line.endswith(f"then its unit is degF; so is {', '.join(hot[1:])}")


def test_micrometres_called_millimetres(doubted):
    found = doubted(signals(), (*HEADER[:4], "z [mm]"))
    assert "micrometres taken for millimetres?" in found["z_um"]


def test_a_drift_in_millimetres_is_doubted_and_the_position_of_an_axis_is_not():
    frame = run_of_day(1).frame
    drift = frame["z_um"] / 1000.0
    lengths = {"disp_z_mm": drift, "x_pos_mm": 5000.0 * drift, "tool_mm": drift}
    run = Run("day", frame.drop(columns="z_um").assign(**lengths))
    assert dict(doubts([run])).keys() == {"disp_z_mm"}
    assert doubts([Run("day", frame.assign(**lengths))]) == []  # Z is measured in um


def test_one_run_among_others_in_another_unit():
    runs = [run_of_day(number) for number in (1, 2, 3)]
    frame = runs[1].frame
    wrong = frame.assign(z_um=frame["z_um"] / 1000.0, time_s=frame["time_s"] / 60.0)
    told = dict(doubts([runs[0], Run("day2", wrong), runs[2]]))
    assert told.keys() == {"z_um", "time_s"}
    assert all(text.endswith("(in day2)") for text in told.values())


def test_minutes_called_seconds(log):
    ((column, text),) = log(table(elapsed(ROWS, 1.0), clock="Zeit [s]")).doubts
    assert column == "time_s"
    assert "minutes taken for seconds? then its unit is min" in text


def test_a_machine_that_warmed_while_nothing_was_recorded():
    frame = run_of_day(1).frame
    columns = [name for name in frame if name.endswith("_degC")]
    frame.loc[:59, columns] = frame.loc[0, columns].to_numpy()
    frame.loc[60:, columns] += 10.0
    frame.loc[60:, "time_s"] += 3.0 * 86400.0
    assert doubts([Run("weekend", frame)]) == []


def test_a_clock_put_forward_by_an_hour_is_doubted_and_a_pause_is_not():
    frame = run_of_day(1).frame
    leapt = frame.assign(time_s=frame["time_s"] + 3600.0 * (frame.index >= 70))
    ((column, text),) = doubts([Run("night", leapt), Run("day", frame)])
    assert column == "time_s"
    assert "at row 72 of night: clock put forward?" in text
    assert doubts([Run("pause", frame.drop(index=range(70, 130)))]) == []
    cold = [name for name in frame if name.endswith("_degC")]
    assert doubts([Run("rest", leapt.assign(**dict.fromkeys(cold, 20.0)))]) == []


@pytest.mark.parametrize("step_s", [60.0, 3600.0, 7200.0, 9000.0])
def test_rows_that_are_hours_apart_are_no_clock_put_forward(step_s):
    frame = run_of_day(1).frame
    assert rows_after(Run("slow", frame.assign(time_s=step_s * frame.index).drop(index=70))) == []


@pytest.mark.long
@pytest.mark.real_data
def test_clocks_of_the_measured_lathe_put_forward(lathe_runs):
    found = told = 0
    for run in map(read_run, lathe_runs):
        time = run.time_s
        for tenth in range(1, 10):
            row = len(time) * tenth // 10
            clock = time + 3600.0 * (np.arange(len(time)) >= row)
            found += rows_after(Run(run.name, run.frame.assign(time_s=clock))) == [row]
            end = int(
                np.searchsorted(time, time[row - 1] + 3600.0 + 0.9 * np.median(np.diff(time)))
            )
            told += rows_after(Run(run.name, run.frame.drop(index=range(row, end)))) != []
    assert (found, told) == (235, 0)  # what clock.py says


def test_one_row_says_nothing():
    assert doubts([Run("one", run_of_day(1).frame.head(1))]) == []


def test_a_growth_that_falls_with_warming(doubted):
    header = (*HEADER[:4], "growth [um]")
    assert "flipped? then set sign = -1" in doubted(signals(), header)["growth_um"]
    values = signals()
    values[:, 4] *= -1.0
    assert doubted(values, header) == {}


def runs_with(sign: dict[int, float], count: int = 4) -> list[Run]:
    found = []
    for number in range(count):
        size = 0.5 + 0.2 * number
        time = 60.0 * np.arange(200)
        rise = size * (1.0 - np.exp(-time / (2000.0 + 500.0 * number)))
        frame = {"time_s": time, "T1_degC": 20 + 9 * rise, "T2_degC": 20 + 4 * rise**2}
        drift = 11.0 * rise - 3.0 * rise**2
        columns = frame | {"z_um": sign.get(number, 1.0) * drift}
        found.append(Run(f"r{number}", pd.DataFrame(columns)))
    return found


def test_a_sign_that_one_run_alone_has():
    assert flipped(runs_with({}), "z_um") == []
    for odd in range(4):
        assert flipped(runs_with({odd: -1.0}), "z_um") == [f"r{odd}"]
    assert flipped(runs_with({0: -1.0}, 2), "z_um") == []  # two runs are no majority
    ((column, text),) = doubts(runs_with({1: -1.0}))
    assert column == "z_um"
    assert "has the opposite sign in r1" in text


@pytest.mark.long
@pytest.mark.real_data
def test_the_measured_lathe_is_not_doubted_and_turned_runs_are(lathe_runs):
    runs = [read_run(path) for path in lathe_runs]
    assert doubts(runs) == []
    hits = 0
    for name in ("disp_x_um", "disp_z_um"):
        for at, run in enumerate(runs):
            turned = list(runs)
            turned[at] = Run(run.name, run.frame.assign(**{name: -run.frame[name]}))
            hits += flipped(turned, name) == [run.name]
    assert hits == 35  # what signs.py says
    for factor in (1.0 / 60.0, 1.0 / 3600.0, 60.0, 1000.0):
        wrong = [Run(run.name, run.frame.assign(time_s=run.time_s * factor)) for run in runs]
        assert all("time_s" in dict(doubts([run])) for run in wrong)


@pytest.mark.long
@pytest.mark.real_data
def test_swapped_thermometers_of_the_measured_lathe(lathe_runs):
    runs = [read_run(path) for path in lathe_runs]
    draw = np.random.default_rng(2)
    hits = cases = 0
    while cases < 20:
        place = int(draw.integers(len(runs)))
        first, second = draw.choice(runs[0].temperatures, 2, replace=False).tolist()
        rises = runs[place].frame[[first, second]] - runs[place].frame[[first, second]].iloc[0]
        if np.sqrt(((rises[first] - rises[second]) ** 2).mean()) < 2.0:
            continue  # they read alike: swapping them changes little
        told = swapped([*runs[:place], plugged(runs[place], first, second), *runs[place + 1 :]])
        assert all(runs[place].name in text for _, text in told)
        hits += any({column, text.split()[2]} == {first, second} for column, text in told)
        cases += 1
    assert hits == 11  # what docs/importing.md says


def plugged(run: Run, first: str, second: str) -> Run:
    """Return a run with two thermometers in each other's place."""
    frame = run.frame.assign(**{first: run.frame[second], second: run.frame[first]})
    return Run(run.name, frame)


def test_swapped_thermometers_are_doubted_in_the_run_where_they_are():
    runs = [run_of_day(number) for number in range(1, 7)]
    assert swapped(runs) == []
    runs[3] = plugged(runs[3], "T0_degC", "T2_degC")
    ((column, text),) = swapped(runs)
    assert {column, text.split()[2]} == {"T0_degC", "T2_degC"}
    assert text.endswith("in day4: swapped there?")


def run_of_day(number: int) -> Run:
    temperatures, drift = day(number)
    columns = {f"T{place}_degC": values for place, values in enumerate(temperatures.T)}
    lengths = {"x_um": drift[:, 0], "z_um": drift[:, 1]}
    return Run(f"day{number}", pd.DataFrame({"time_s": clock_s(), **columns, **lengths}))


def test_a_sensor_out_of_range_for_a_moment_is_no_other_unit(doubted):
    values = signals(400)
    values[150:156, 4] = -99999.9
    assert doubted(values) == {}
