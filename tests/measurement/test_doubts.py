"""What the numbers contradict is doubted, and what is as it should be is not."""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from measurement.doubts import doubt_lines, doubts
from measurement.doubts.places import swapped
from measurement.doubts.signs import flipped
from measurement.importing.log import import_files
from measurement.runs import Run, read_run
from tests.measurement.importing.made import HEADER, elapsed, signals, table
from tests.measurement.lab import clock_s, day


def doubted(
    tmp_path: Path, values: np.ndarray, header: tuple[str, ...] = HEADER, step: str = "s"
) -> dict[str, str]:
    path = tmp_path / "log.csv"
    rows = elapsed(len(values), 1.0 if step == "min" else 60.0)
    clock = "Zeit [s]"
    path.write_text(table(rows, clock=clock, header=header, values=values), encoding="utf-8")
    return dict(import_files([path]).doubts)


def test_a_sound_log_raises_no_doubt(tmp_path):
    assert doubted(tmp_path, signals()) == {}


@pytest.mark.parametrize(
    ("factor", "offset", "told"), [(1.0, 273.15, "kelvin"), (1.8, 32.0, "Fahrenheit")]
)
def test_one_temperature_or_all_in_another_unit(factor, offset, told, tmp_path):
    for columns in ([0], [1, 2], [0, 1, 2]):
        values = signals()
        values[:, columns] = values[:, columns] * factor + offset
        found = doubted(tmp_path, values)
        names = ["Temp_Lager_vorn_degC", "T_hinten_degC", "Halle_degC"]
        assert set(found) == {names[column] for column in columns}
        assert all(told in text for text in found.values())


def test_columns_that_are_doubted_alike_share_a_line():
    runs = [run_of_day(number) for number in (1, 2, 3)]
    hot = [name for name in runs[0].frame if name.endswith("_degC")]
    wrong = [
        Run(run.name, run.frame.assign(**{n: 1.8 * run.frame[n] + 32 for n in hot})) for run in runs
    ]
    (line,) = doubt_lines(wrong)
    assert line.endswith(f"then its unit is degF; so is {', '.join(hot[1:])}")


def test_millimetres_called_micrometres_and_the_other_way_round(tmp_path):
    values = signals()
    values[:, 4] /= 1000.0
    assert (
        "millimetres taken for micrometres? then its unit is mm"
        in doubted(tmp_path, values)["z_um"]
    )
    header = (*HEADER[:4], "z [mm]")
    found = doubted(tmp_path, signals(), header)
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


def test_minutes_called_seconds(tmp_path):
    found = doubted(tmp_path, signals(), step="min")
    assert set(found) == {"time_s"}
    assert "minutes taken for seconds? then its unit is min" in found["time_s"]


def test_thousands_of_turns(tmp_path):
    values = signals()
    values[:, 3] /= 1000.0
    assert "krpm" in doubted(tmp_path, values)["speed_rpm"]


def test_a_growth_that_falls_with_warming(tmp_path):
    header = (*HEADER[:4], "growth [um]")
    assert "flipped? then set sign = -1" in doubted(tmp_path, signals(), header)["growth_um"]
    values = signals()
    values[:, 4] *= -1.0
    assert doubted(tmp_path, values, header) == {}


def runs_with(sign: dict[int, float], count: int = 4) -> list[Run]:
    found = []
    for number in range(count):
        size = 0.5 + 0.2 * number
        time = 60.0 * np.arange(200)
        rise = size * (1.0 - np.exp(-time / (2000.0 + 500.0 * number)))
        frame = {"time_s": time, "T1_degC": 20 + 9 * rise, "T2_degC": 20 + 4 * rise**2}
        drift = 11.0 * rise - 3.0 * rise**2
        found.append(Run(f"r{number}", _frame(frame | {"z_um": sign.get(number, 1.0) * drift})))
    return found


def _frame(columns: dict[str, np.ndarray]) -> pd.DataFrame:
    return pd.DataFrame(columns)


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
    return Run(f"day{number}", _frame({"time_s": clock_s(), **columns, **lengths}))


def test_a_sensor_out_of_range_for_a_moment_is_no_other_unit(tmp_path):
    values = signals(400)
    values[150:156, 4] = -99999.9
    assert doubted(tmp_path, values) == {}


def test_tenths_of_a_degree_are_whole_numbers(tmp_path):
    values = signals()
    values[:, :3] = (10.0 * values[:, :3]).round()
    found = doubted(tmp_path, values)
    assert [text.rpartition("then ")[2] for text in found.values()] == 3 * ["its unit is 0.1 degC"]
