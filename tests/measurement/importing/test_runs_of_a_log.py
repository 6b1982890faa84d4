"""A long log becomes runs, and tables of several recorders become one log."""

import datetime as dt
from itertools import pairwise
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from measurement.errors import BadInput
from measurement.importing.log import import_files
from measurement.importing.mapping import Mapping, read_mapping
from measurement.importing.splitting import warm_starts
from measurement.runs import read_run
from measurement.warm import WARM_START
from plant_model.machine_file import read_machine
from plant_model.simulate import simulate
from tests.measurement.importing.made import HEADER, signals, stamps, table
from tests.refusing import refusal

DAY0 = dt.datetime(2026, 3, 2)


@pytest.fixture(scope="module")
def two_days() -> pd.DataFrame:
    """A log of two days from 7 o'clock on, each of two shifts."""
    hours = np.arange(0.0, 36.0, 1.0 / 60.0)
    of_day = (hours + 7.0) % 24.0
    works = ((of_day > 7.5) & (of_day < 11.5)) | ((of_day > 12.5) & (of_day < 16.0))
    columns = {"time_s": 3600.0 * hours, "speed_rpm": np.where(works, 9000.0, 0.0)}
    inputs = pd.DataFrame(columns | {"T5_degC": 21.0, "T9_degC": 21.0})
    return simulate(read_machine("jig_borer_lumps"), inputs, noise_seed=1).run_frame()


@pytest.fixture(scope="module")
def with_rests(two_days: pd.DataFrame) -> pd.DataFrame:
    """Its rows but those of a rest of 40 minutes between the shifts, and of the nights."""
    of_day = (two_days["time_s"] / 3600.0 + 7.0) % 24.0
    logged = ((of_day >= 7.0) & (of_day < 11.5)) | ((of_day > 12.19) & (of_day < 16.5))
    return two_days[logged]


def stamped(frame: pd.DataFrame) -> str:
    """Return the text of a log that begins at 7 o'clock."""
    clock = DAY0 + pd.to_timedelta(frame["time_s"], unit="s") + dt.timedelta(hours=7)
    return str(frame.drop(columns="time_s").assign(time=clock).to_csv(index=False))


def test_a_log_is_cut_at_pauses_and_its_warm_restarts_are_marked(with_rests, log):
    found = log(stamped(with_rests))
    assert [run.name for run in found.runs] == [
        "20260302_0700", "20260302_1212", "20260303_0700", "20260303_1212"
    ]  # fmt: skip
    assert [piece.warm for piece in found.pieces] == [None, True, False, True]
    assert [round(piece.rested_s / 3600.0, 1) for piece in found.pieces[1:]] == [0.7, 14.5, 0.7]
    for piece in found.pieces:
        assert piece.run.time_s[0] == 0.0
        told = None if piece.warm is None else {float(piece.warm)}
        assert (set(piece.run.frame[WARM_START]) if WARM_START in piece.run.frame else None) == told
    whole = pd.concat([run.frame["T1_degC"] for run in found.runs])
    np.testing.assert_array_equal(whole, with_rests["T1_degC"])  # nothing invented, nothing lost


def nose_and_hall(rises: list[float], rests_h: list[float]) -> list[bool | None]:
    """Return what is told of runs in which the nose warms so much, in a hall that warms up."""
    parts, rows = [], []
    for number, rise in enumerate(rises):
        hall = np.linspace(20.0 + 2.0 * number, 22.0 + 2.0 * number, 50)
        nose = hall + np.linspace(0.0, rise, 50)
        rows.append(np.column_stack([nose, hall, hall + 0.1, hall - 0.1]))
        parts.append(np.arange(50 * number, 50 * number + 50))
    frame = pd.DataFrame(np.concatenate(rows), columns=["nose_degC", "a_degC", "b_degC", "c_degC"])
    return warm_starts(frame, parts, [np.nan, *(3600.0 * rest for rest in rests_h)], 28800.0)


@pytest.mark.parametrize(
    ("rises", "rests_h", "told"),
    [
        ([9.0], [], [None]),
        ([9.0, 9.0], [1.0], [None, True]),
        ([0.0, 9.0, 9.0], [1.0, 1.0], [None, None, True]),  # a hall that warms warms no machine
        ([9.0, 0.0, 9.0, 9.0], [12.0, 1.0, 1.0], [None, False, False, True]),
        ([9.0, 9.0, 9.0], [7.9, 8.0], [None, True, False]),
    ],
)
def test_a_warm_start_comes_soon_after_a_run_that_warmed(rises, rests_h, told):
    assert nose_and_hall(rises, rests_h) == told


@pytest.mark.long
@pytest.mark.real_data
def test_every_run_of_the_measured_lathe_warms(lathe_runs):
    frames = [read_run(path).frame for path in lathe_runs]
    parts = [np.arange(a, b) for a, b in pairwise(np.cumsum([0, *map(len, frames)]))]
    for rest, told in ((18 * 3600.0, False), (3600.0, True)):
        rests = [np.nan, *[rest] * (len(parts) - 1)]
        found = warm_starts(pd.concat(frames), parts, rests, 28800.0)
        assert found == [None, *[told] * (len(parts) - 1)]


def test_days_and_no_split(two_days, with_rests, log):
    assert len(log(stamped(two_days)).runs) == 1
    days = log(stamped(two_days), mapping=Mapping(split="days"))
    assert [run.name for run in days.runs] == ["20260302_0700", "20260303_0000"]
    assert len(log(stamped(with_rests), mapping=Mapping(split="none")).runs) == 1
    with pytest.raises(BadInput, match="has no dates, so it cannot be split into days"):
        log(table(), mapping=Mapping(split="days"))


def two_recorders(tmp_path: Path) -> list[Path]:
    values = signals(40)
    fast = table(stamps("%H:%M:%S"), header=["T1 [°C]"], values=values[:, :1], clock="Zeit")
    times = [
        (dt.datetime(2026, 3, 2, 7, 15, 30) + dt.timedelta(seconds=90 * n)).strftime("%H:%M:%S")
        for n in range(26)
    ]
    slow = table(times, header=["z [µm]"], values=values[:26, 4:], clock="Uhrzeit")
    for name, text in (("temperatures.csv", fast), ("probe.csv", slow)):
        (tmp_path / name).write_text(text, encoding="utf-8")
    return [tmp_path / "temperatures.csv", tmp_path / "probe.csv"]


def test_two_clocks_are_joined_without_a_row_or_a_value_invented(tmp_path):
    found = import_files(two_recorders(tmp_path))
    (run,) = found.runs
    values = signals(40)
    temperature = run.frame[run.frame["T1_degC"].notna()]
    probe = run.frame[run.frame["z_um"].notna()]
    np.testing.assert_allclose(temperature["time_s"], 60.0 * np.arange(40))
    np.testing.assert_allclose(temperature["T1_degC"], values[:, 0])
    np.testing.assert_allclose(probe["time_s"], 30.0 + 90.0 * np.arange(26))
    np.testing.assert_allclose(probe["z_um"], values[:26, 4])
    both = {*(60.0 * np.arange(40)), *(30.0 + 90.0 * np.arange(26))}
    assert len(run.frame) == len(both)
    assert any("--every SECONDS puts them on one grid" in note for note in found.notes)


def test_an_even_grid_fills_what_lies_between_and_nothing_else(tmp_path):
    (run,) = import_files(two_recorders(tmp_path), Mapping(every_s=60.0)).runs
    np.testing.assert_allclose(np.diff(run.time_s), 60.0)
    assert run.frame["z_um"].iloc[1:38].notna().all()
    assert np.isnan(run.frame["z_um"].iloc[0])


def test_files_with_the_same_columns_follow_each_other_or_are_runs(tmp_path):
    paths = []
    for number, start in enumerate(("02.03.2026", "03.03.2026")):
        text = table([f"{start} {time}" for time in stamps("%H:%M:%S")])
        paths.append(tmp_path / f"{number}.csv")
        paths[-1].write_text(text, encoding="utf-8")
    names = [run.name for run in import_files(paths[::-1]).runs]
    assert names == ["20260302_0715", "20260303_0715"]
    for path in paths:
        path.write_text(table(), encoding="utf-8")
    assert [run.name for run in import_files(paths).runs] == ["0", "1"]


def test_a_time_of_day_gets_the_date_of_the_table_that_its_name_goes_with(tmp_path):
    days = ("02.03.2026", "03.03.2026")
    paths = []
    for number, day in enumerate(days):
        temperatures, probe = two_recorders(tmp_path)
        dated = temperatures.read_text(encoding="utf-8").replace("\n07:", f"\n{day} 07:")
        paths += [tmp_path / f"temperatures_{number}.csv", tmp_path / f"probe_{number}.csv"]
        paths[-2].write_text(dated, encoding="utf-8")
        probe.rename(paths[-1])
    runs = import_files(paths).runs
    assert [run.name for run in runs] == ["20260302_0715", "20260303_0715"]
    for run in runs:
        probe_s = run.time_s[run.frame["z_um"].notna()]
        np.testing.assert_allclose(probe_s, 30.0 + 90.0 * np.arange(26))
    # Which of two days a lone probe's times are of nobody can tell.
    assert "counts from an unknown start" in refusal(import_files, [paths[0], paths[2], paths[1]])


def test_the_mapping_file_round_trips_and_is_followed(tmp_path):
    path, mapping = tmp_path / "log.csv", tmp_path / "import.toml"
    header = ["T1", "Druck [bar]", "Halle [°C]", "Drehzahl [1/min]", "z [µm]"]
    path.write_text(table(header=header), encoding="utf-8")
    first = import_files([path])
    assert set(first.hints) == {"T1", "Druck [bar]"}
    assert "perhaps degC: --unit 'T1=degC'" in first.hints["T1"]
    assert list(first.runs[0].frame) == ["time_s", "Halle_degC", "speed_rpm", "z_um"]
    text = first.mapping_text()
    mapping.write_text(text, encoding="utf-8")
    again = import_files([path], read_mapping(mapping))
    assert again.mapping == first.mapping
    assert again.mapping_text() == text
    text = text.replace('T1 = {name = "T1", unit = ""}', 'T1 = {name = "front", unit = "degC"}')
    text = text.replace('{name = "Druck", unit = ""}', '{name = "Druck", keep = false}')
    text = text.replace('{name = "z", unit = "µm"}', '{name = "z", unit = "µm", sign = -1}')
    mapping.write_text(text, encoding="utf-8")
    mended = import_files([path], read_mapping(mapping))
    assert mended.hints == {}
    (run,) = mended.runs
    np.testing.assert_allclose(run.frame["front_degC"], signals()[:, 0])
    np.testing.assert_allclose(run.frame["z_um"], -signals()[:, 4])


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        ("spindle-drift import", "else", 'kind: is not "spindle-drift import"'),
        ('split = "pauses"', 'split = "weeks"', "split: 'weeks' is not allowed"),
        ("pause_s = 1800.0", "pause_s = -1", "pause_s: -1 is not allowed"),
        ("[columns]", "[colums]", "colums: is not a known field"),
        ("format = 1", "format = ", "is not TOML"),
    ],
)
def test_a_mapping_file_that_will_not_do_is_refused(old, new, told, log, tmp_path):
    text, mapping = log(table()).mapping_text(), tmp_path / "import.toml"
    assert old in text
    mapping.write_text(text.replace(old, new), encoding="utf-8")
    said = refusal(read_mapping, mapping)
    assert told in said
    assert str(mapping) in said


@pytest.mark.parametrize("dated", [True, False])
def test_days_with_a_thermometer_more_or_less_follow_each_other(dated, tmp_path):
    """No other thermometer is lost for it, and no name has to be changed."""
    paths = []
    for day, header in enumerate((HEADER, HEADER[1:], (*HEADER, "Spindel [°C]"))):
        begin = DAY0 + dt.timedelta(days=day)
        clock = [(begin + dt.timedelta(minutes=n)).isoformat(" ") for n in range(40)]
        values = np.column_stack([signals(), signals()[:, 0]])
        shown = [([*HEADER, "Spindel [°C]"]).index(name) for name in header]
        given = {"header": header, "values": values[:, shown]}
        told = table(clock, **given) if dated else table(**given)
        paths.append(tmp_path / f"day{day}.csv")
        paths[-1].write_text(told, encoding="utf-8")
    found = import_files(paths)
    first, second, third = found.runs
    assert found.notes == ()
    assert first.frame["T_hinten_degC"].equals(third.frame["T_hinten_degC"])
    assert not second.frame.get("Temp_Lager_vorn_degC", pd.Series(np.nan)).notna().any()
    assert third.frame["Spindel_degC"].notna().all()


def test_logs_of_one_name_from_two_folders_are_two_runs(tmp_path):
    paths = [tmp_path / day / "log.csv" for day in ("mon", "tue")]
    for path in paths:
        path.parent.mkdir()
        path.write_text(table(), encoding="utf-8")
    assert [run.name for run in import_files(paths).runs] == ["mon_log", "tue_log"]
    assert "log.csv: is given twice" in refusal(import_files, [paths[0], paths[0]])
