"""The same log in every form that recorders and spreadsheets give it."""

import datetime as dt
import json
from pathlib import Path

import numpy as np
import openpyxl
import pandas as pd
import pytest

from measurement.errors import BadInput
from measurement.importing.log import Imported, import_files
from measurement.importing.mapping import Mapping, TimeRule
from measurement.importing.text_tables import separator_of
from tests.measurement.importing.made import (
    HEADER,
    START,
    elapsed,
    german,
    signals,
    stamps,
    table,
    workbook,
)
from tests.refusing import refusal

NAMES = ["time_s", "Temp_Lager_vorn_degC", "T_hinten_degC", "Halle_degC", "speed_rpm", "z_um"]
PLAIN = [header.partition(" [")[0].partition(" (")[0] for header in HEADER]
UNITS = ["°C", "degC", "°C", "1/min", "µm"]
MM = np.array([1.0, 1.0, 1.0, 1.0, 1e-3])
FREEZING_K = np.array([273.15, 0.0, 0.0, 0.0, 0.0])
DEGF_PER_K, FREEZING_F = np.array([[1.0, 1.8, 1.8, 1.0, 1.0], [0.0, 32.0, 32.0, 0.0, 0.0]])
LOCAL, ISO = "%d.%m.%Y %H:%M:%S", "%Y-%m-%dT%H:%M:%S"
BERLIN = Mapping(time=TimeRule(timezone="Europe/Berlin"))


def check(found: Imported, step_s: float = 60.0) -> None:
    (run,) = found.runs
    assert list(run.frame.columns) == NAMES
    np.testing.assert_allclose(run.time_s, step_s * np.arange(len(run.time_s)), atol=1e-6)
    np.testing.assert_allclose(run.frame[NAMES[1:]], signals(len(run.time_s)), atol=1e-9)
    assert found.hints == {}
    assert found.doubts == ()


def scope(clock: list[str], *, before_each: bool) -> str:
    """Return what TwinCAT's Scope View exports, a clock before each channel or one for all."""

    def line(first: str, others: list[str]) -> str:
        return "\t".join(f"{first}\t{one}" for one in others if before_each) or "\t".join(
            [first, *others]
        )

    about = [
        line("Name", [*HEADER[:4], "z"]),
        line("SymbolComment", 5 * [""]),
        line("SampleTime[ms]", 5 * ["60000"]),
        line("Unit", [*4 * ["(None)"], "µm (Length)"]),
    ]
    rows = [
        line(at, [german(value) for value in row]) for at, row in zip(clock, signals(), strict=True)
    ]
    start = "Starttime of export\t132959733843760000\tMontag, 2. Mai 2022\t15:56:24.376"
    return "\n".join(["Name\tDrift", start, "", "", *about, "", *rows, "EOF"])


PREAMBLE = "Messung 7;Spindel\nBediener;Müller;Halle 3\n\n"
UNITS_BELOW = "Zeit;Temp. Lager vorn;T hinten;Halle;Drehzahl;z\n;°C;degC;[°C];1/min;µm\n"
SECONDS = table()
LINES = SECONDS.split("\n")
TEXTS = {
    "semicolons and commas": SECONDS,
    "tabs": table(mark="\t"),
    "commas and points": table(clock="t [s]", mark=",", comma=False),
    "minutes": table(elapsed(step=1), clock="Zeit / min"),
    "hours": table([f"{n / 60:.9f}".replace(".", ",") for n in range(40)], clock="Zeit (h)"),
    "milliseconds": table(elapsed(step=60000), clock="Time, ms"),
    "local times": table(stamps(LOCAL)),
    "local times with milliseconds": table(stamps("%d.%m.%Y %H:%M:%S,250")),
    "ISO": table(stamps(ISO), clock="timestamp"),
    "colons before milliseconds": table(stamps("%d.%m.%Y %H:%M:%S:250")),
    "signs apart from numbers": SECONDS.replace(";2", ";+    2").replace(";-", ";-   "),
    "thousands set apart by points": SECONDS.replace(";6000;", ";6.000;"),
    "thousands set apart by commas": table(comma=False).replace(";6000;", ";6,000;"),
    "thousands set apart by blanks": SECONDS.replace(";6000;", ";6\u202f000;"),
    "minus signs of their own": SECONDS.replace(";-", ";\N{MINUS SIGN}"),
    "nanoseconds since 1970": table([f"{1.7e18 + 6e10 * n:.0f}" for n in range(40)], clock="Time"),
    "seconds since 1904": table([f"{3.85e9 + 60 * n:.0f}" for n in range(40)], clock="Time"),
    "days of a spreadsheet": table(
        [f"{46083.25 + n / 1440:.12f}".replace(".", ",") for n in range(40)], clock="Date"
    ),
    "settings of the recorder with numbers": "Intervall;60s\nKanal;Name;Art;Spanne;0;100;C\n"
    + SECONDS,
    "a line below": SECONDS + "Ende der Messung;;;;;\n",
    "means and maxima below": SECONDS + "\nMittel;25;23;20,5;5700;-6\nMax;28;24;20,7;6000;0\n",
    "ISO with a zone": table(stamps(ISO + "+01:00"), clock="timestamp"),
    "ISO, universal": table(stamps(ISO + "Z"), clock="timestamp"),
    "month first": table(stamps("%m/%d/%Y %I:%M:%S %p", 40, 60.0), clock="Date/Time"),
    "month named": table(stamps("%d-%b-%Y %H:%M:%S"), clock="Time"),
    "two digits of a year": table(stamps("%d.%m.%y %H:%M"), clock="Datum"),
    "date and time of day": table(stamps("%d.%m.%Y;%H:%M:%S"), clock="Datum;Uhrzeit"),
    "time of day": table(stamps("%H:%M:%S"), clock="Uhrzeit"),
    "since 1970": table([f"{1.7e9 + 60 * n:.0f}" for n in range(40)], clock="Time"),
    "preamble": PREAMBLE + SECONDS,
    "units below the names": UNITS_BELOW + "\n".join(table(stamps(LOCAL)).split("\n")[1:]),
    "comments below the units": UNITS_BELOW.replace("Zeit;", "Zeit  1 - Messrate;").replace(
        "\n;", "\ns;"
    )
    + "".join(f"{k};" for k in range(5)).replace(";", " MX1609;")
    + "5 MX1609\n"
    + "\n".join(table(stamps(LOCAL)).split("\n")[1:]),
    "the header once more": "\n".join([*LINES[:9], "", LINES[0], *LINES[9:]]),
    "a clock before each channel": scope(elapsed(step=60000), before_each=True),
    "full time stamps": scope(
        [f"{132959733843760000 + 600_000_000 * n}" for n in range(40)], before_each=False
    ),
    "separator told": "sep=;\n" + SECONDS,
    "a separator at the end": SECONDS.replace("\n", ";\n"),
    "a row cut off": SECONDS.rstrip("\n") + "\n2400;25",
    "quoted names": SECONDS.replace("z [µm]", '"z [µm]"'),
    "kelvin": table(header=["Temp. Lager vorn [K]", *HEADER[1:]], values=signals() + FREEZING_K),
    "fahrenheit": table(
        header=[HEADER[0], "T hinten (degF)", "Halle [°F]", *HEADER[3:]],
        values=signals() * DEGF_PER_K + FREEZING_F,
    ),
    "millimetres": table(header=[*HEADER[:4], "z [mm]"], values=signals() * MM),
    "a row for each value": "\n".join(
        [
            "timestamp;tag;value;unit;quality",
            *(
                f"{time};{name};{german(value)};{unit};GOOD"
                for time, row in zip(stamps(LOCAL), signals(), strict=True)
                for name, value, unit in zip(PLAIN, row, UNITS, strict=True)
            ),
        ]
    ),
}
DAY_OR_MONTH = {"month first": Mapping(time=TimeRule(day_first=False))}


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "cp1252", "utf-16"])
def test_every_encoding(encoding, log):
    check(log(SECONDS.replace("\n", "\r\n").encode(encoding)))


@pytest.mark.parametrize("form", TEXTS)
def test_every_form_of_a_text_table(form, log):
    check(log(TEXTS[form], mapping=DAY_OR_MONTH.get(form)))


def test_decimal_commas_in_quotes_separate_nothing_where_cells_are_empty():
    rows = [f'{n},"{n},5",' + (f'"{n},25"' if n % 2 else "") for n in range(20)]
    assert separator_of("\n".join(["Time,T,z", *rows]), Path("log.csv")) == ","


MOMENTS = [START + dt.timedelta(minutes=n) for n in range(40)]
ROWS = [
    ["Zeit", *HEADER],
    *([time, *row] for time, row in zip(MOMENTS, signals().tolist(), strict=True)),
]
"""Of a sheet."""


@pytest.mark.parametrize("ending", [".xlsx", ".xls"])
def test_a_workbook_with_a_cover_and_two_sheets(ending, tmp_path):
    parts = {
        "Deckblatt": [["Messung"]],
        "Temperaturen": [["Messung 7"], [], *(row[:4] for row in ROWS)],
        "Achsen": [[row[0], *row[4:]] for row in ROWS],
    }
    check(import_files([workbook(tmp_path / f"log{ending}", parts)]))


@pytest.mark.parametrize(
    ("heads", "merged"),
    [
        ([["Time [s]", "Bearing [°C]", None, "Drive [°C]", None, "Drift [µm]"]], "B1:C1 D1:E1"),
        (
            [["Rig 7"], ["Time [s]", "Bearing", None, "Drive", None, "Drift"]],
            "A1:F1 A2:A4 B2:C2 D2:E2 B4:E4",
        ),
    ],
)
def test_what_is_merged_over_columns_is_part_of_their_names(heads, merged, tmp_path):
    """A group over columns that share their names, and a unit of several of them."""
    book = openpyxl.Workbook()
    for row in (*heads, [None, "front", "rear", "front", "rear", "z"]):
        book.active.append(row)
    if len(heads) > 1:
        book.active.append([None, "°C", None, None, None, "µm"])
    for n, row in enumerate(signals()[:, [0, 1, 2, 2, 4]].tolist()):
        book.active.append([60.0 * n, *row])
    for cells in merged.split():
        book.active.merge_cells(cells)
    book.save(tmp_path / "log.xlsx")
    found = import_files([tmp_path / "log.xlsx"])
    names = ["Bearing_front_degC", "Bearing_rear_degC", "Drive_front_degC", "Drive_rear_degC"]
    assert list(found.runs[0].frame)[1:5] == names
    assert found.hints == {}


def test_a_heading_that_is_merged_over_two_rows(tmp_path):
    over = ["Zeit", "Temperaturen", *(len(HEADER) - 1) * [None]]
    sheets = {"Log": [over, [None, *HEADER], *ROWS[1:]]}
    check(import_files([workbook(tmp_path / "log.xlsx", sheets)]))


def test_a_hidden_sheet_is_left_out_and_told(tmp_path):
    path = workbook(tmp_path / "log.xlsx", {"Log": ROWS, "old": ROWS})
    book = openpyxl.load_workbook(path)
    book["old"].sheet_state = "hidden"
    book.save(path)
    found = import_files([path])
    check(found)
    assert found.notes == (f"{path}, Log: left out: old: is hidden",)


def test_a_wire_that_broke_is_missing_and_told(log):
    values = signals()
    values[15:, 1] = -999.0
    found = log(table(values=values))
    (run,) = found.runs
    np.testing.assert_allclose(run.frame["T_hinten_degC"][:15], signals()[:15, 1])
    assert run.frame["T_hinten_degC"][15:].isna().all()
    told = "row 17, column T hinten (degC): -999 degC is outside -60..400 degC: it and 24 more are"
    assert any(told in note for note in found.notes)


@pytest.mark.parametrize("sign", ["inf", "-Infinity", "1.#INF"])
def test_a_reading_beyond_all_numbers_is_missing_and_told(sign, log):
    found = log(SECONDS.replace(";20,75;", f";{sign};"))
    assert found.runs[0].frame["T_hinten_degC"].isna().tolist() == [True] + 39 * [False]
    shown = "-inf" if "-" in sign else "inf"
    told = f"column T hinten (degC): {shown} degC is outside -60..400 degC: it is taken for missing"
    assert any(told in note for note in found.notes)


def test_infinite_readings_ask_for_no_other_unit(log):
    values = signals()
    values[3, 1], values[5, 1], values[7:9, 1] = np.inf, -np.inf, -999.0
    found = log(table(values=values))
    assert found.runs[0].frame["T_hinten_degC"].isna().sum() == 4
    assert sum("is outside -60..400" in note for note in found.notes) == 2


def test_a_time_beyond_all_numbers_is_refused(log):
    said = refusal(log, SECONDS.replace("\n60;", "\ninf;"))
    assert "row 3, column Zeit [s]: is missing; every row needs a time" in said


@pytest.mark.parametrize("sign", ["****", "+OVER", "?", "-1.#IND", "BURNOUT", "#NV"])
def test_signs_of_no_value(sign, log):
    found = log(SECONDS.replace(";20,75;", f";{sign};"))
    assert np.isnan(found.runs[0].frame["T_hinten_degC"][0])


@pytest.mark.parametrize(("decimal", "thousand"), [(",", "6.000"), (".", "6,000")])
def test_thousands_are_set_apart_further_down_than_the_decimal_mark_is_looked_for(
    decimal, thousand, log
):
    values = signals(500)
    values[:490, 3] = 0.0
    text = table(values=values, comma=decimal == ",").replace(";6000;", f";{thousand};")
    assert log(text).runs[0].frame["speed_rpm"].tolist() == values[:, 3].tolist()


@pytest.mark.parametrize("names", [("Zeit", "Zeit"), ("t [s]", "t2 [s]")])
def test_blocks_side_by_side_have_their_own_clocks(names, tmp_path):
    local = names[0] == "Zeit"
    clock = [START + dt.timedelta(minutes=n) if local else 60.0 * n for n in range(40)]
    head = [names[0], HEADER[0], None, names[1], HEADER[4]]
    rows = [
        [clock[n], 20.0 + n, None, *((clock[2 * n], float(2 * n)) if n < 20 else (None, None))]
        for n in range(40)
    ]
    (run,) = import_files([workbook(tmp_path / "log.xlsx", {"Log": [head, *rows]})]).runs
    frame = run.frame.dropna()
    assert frame["z_um"].tolist() == (frame["time_s"] / 60.0).tolist() == list(range(0, 40, 2))


def test_tables_of_a_fast_recorder_lose_no_rows(tmp_path):
    clock = [f"{0.0005 * n:.4f}" for n in range(40)]
    for name, column in (("T", HEADER[0]), ("z", HEADER[4])):
        text = "\n".join([f"t [s];{column}", *(f"{now};{n}" for n, now in enumerate(clock))])
        (tmp_path / f"{name}.csv").write_text(text, encoding="utf-8")
    (run,) = import_files([tmp_path / "T.csv", tmp_path / "z.csv"]).runs
    assert run.frame.iloc[:, 1].tolist() == run.frame.iloc[:, 2].tolist() == list(range(40))


@pytest.mark.parametrize(
    ("header", "column", "each"),
    [
        ("disp_z (mils)", "disp_z_um", 25.4),
        ("disp_z [µin]", "disp_z_um", 0.0254),
        ('disp_z (0.0001")', "disp_z_um", 2.54),
        ("disp_z [inch]", "disp_z_um", 25.4e3),
        ("Tool length [inch]", "Tool_length_mm", 25.4),
        ("Feed (ipm)", "feed_mm_min", 25.4),
        ("Spindle torque (ft-lb)", "Spindle_torque_Nm", 1.3558179483314),
        ("Spindle motor [hp]", "Spindle_motor_W", 745.69987158),
        ("Coolant (gpm)", "Coolant_lpm", 3.785411784),
    ],
)
def test_imperial_units_are_those_of_machine_tools(header, column, each, log):
    frame = log(f"time [s];{header}\n0;0\n10;1\n20;4\n").runs[0].frame
    assert list(frame) == ["time_s", column]
    np.testing.assert_allclose(frame[column], [0.0, each, 4.0 * each], atol=1e-9)


@pytest.mark.parametrize("header", ["Front bearing, deg F", "Front bearing deg. F"])
def test_degrees_may_be_a_word_of_their_own(header, log):
    frame = log(f"time [s];{header}\n0;68\n10;77\n20;86\n").runs[0].frame
    assert frame["Front_bearing_degC"].tolist() == [20.0, 25.0, 30.0]


@pytest.mark.parametrize("name", ["Temp IPM", "Temp HP"])
def test_a_power_module_or_high_pressure_is_no_unit(name, log):
    assert name in log(f"time [s];{name};z [µm]\n0;20;0\n10;21;1\n20;22;3\n").hints


def test_an_axis_makes_a_displacement_of_a_position(log):
    text = table(header=[*HEADER[:4], "Pos Z [mm]"], values=signals() * MM)
    frame = log(text, axes={"Pos Z [mm]": "-Z"}).runs[0].frame
    np.testing.assert_allclose(frame["Pos_Z_um"], -signals()[:, 4], atol=1e-9)


def test_a_log_without_values_in_a_column_does_not_speak_for_the_others(tmp_path):
    for day, cell in ((1, "7,5"), (2, "")):
        lines = [f"0{day}.03.2026 06:0{minute};21,5;21,0;{cell}" for minute in range(3)]
        text = "\n".join(["Zeit;T1 [°C];T2 [°C];z [µm]", *lines])
        (tmp_path / f"day{day}.csv").write_text(text, encoding="utf-8")
    found = import_files([tmp_path / "day1.csv", tmp_path / "day2.csv"])
    assert found.mapping.columns["z [µm]"].unit == "µm"
    assert found.hints == {}
    assert found.notes == (f"{tmp_path / 'day2.csv'}: column z [µm] holds no value",)


@pytest.mark.parametrize("form", [LOCAL, "%H:%M:%S"])
def test_a_log_with_the_newest_row_first(form, log):
    found = log(table(stamps(form)[::-1], values=signals()[::-1]))
    check(found)
    assert "newest first" in found.notes[0]


@pytest.mark.parametrize("name", ["T [°C]", "T2 [°C]", "T2"])
def test_a_temperature_between_others_begins_no_block(name, log):
    header = [HEADER[4], name, *HEADER[1:4]]
    text = table(header=header, values=signals()[:, [4, 0, 1, 2, 3]])
    (run,) = log(text, units={"T2": "degC"} if name == "T2" else {}).runs
    assert run.frame.iloc[:, 2].tolist() == signals()[:, 0].tolist()


def test_of_several_speeds_none_is_known_and_that_is_told(log):
    header = [HEADER[0], "S set [rpm]", HEADER[2], "S act [rpm]", HEADER[4]]
    (note,) = log(table(header=header)).notes
    assert note.startswith('no speed is known: name = "speed"')
    assert note.endswith("S set [rpm], S act [rpm]")


def test_rows_of_whole_seconds_are_spread_and_told(log):
    clock = [(START + dt.timedelta(seconds=n // 4)).strftime(LOCAL) for n in range(40)]
    found = log(table(clock))
    np.testing.assert_allclose(found.runs[0].time_s, np.arange(40) / 4.0)
    assert "30 rows share the previous row's time stamp" in found.notes[0]


@pytest.mark.parametrize("day", ["2026-10-25", "2026-03-29"])
def test_clocks_set_back_or_put_forward_are_undone_with_a_zone(day, log):
    begin = pd.Timestamp(f"{day} 01:30", tz="Europe/Berlin")
    local = [(begin + pd.Timedelta(minutes=5 * n)).strftime(LOCAL) for n in range(40)]
    check(log(table(local), mapping=BERLIN), 300.0)
    if day == "2026-03-29":  # put forward, which looks like a pause
        (note,) = log(table(local)).notes
        assert "the pause from 2026-03-29 01:55:00 may be no pause" in note


def test_elapsed_time_put_forward_by_an_hour_is_noted(log):
    clock = [f"{60 * n + 3600 * (n >= 15)}" for n in range(40)]
    (note,) = log(table(clock, clock="Zeit [s]")).notes
    assert "the pause after 840 s may be no pause" in note


def test_with_a_zone_runs_are_named_and_cut_by_the_clock_on_the_wall(log):
    local = [pd.Timestamp("2026-03-01 22:00") + pd.Timedelta(minutes=10 * n) for n in range(40)]
    written = [at.strftime(LOCAL) for at in local]
    serial = [f"{(at - pd.Timestamp('1899-12-30')) / pd.Timedelta(days=1):.9f}" for at in local]
    days = BERLIN.model_copy(update={"split": "days"})
    zoned = [at.strftime("%Y-%m-%dT%H:%M:%S+01:00") for at in local]
    serial = [at.replace(".", ",") for at in serial]
    for text in (table(written), table(zoned), table(serial, clock="Zeit [d]")):
        found = log(text, mapping=days)
        assert [run.name for run in found.runs] == ["20260301_2200", "20260302_0000"]
        assert found.pieces[1].starts == "2026-03-02 00:00:00"


def test_a_night_is_passed_by_times_of_day(log):
    clock = [f"{(22 + n // 2) % 24:02d}:{30 * (n % 2):02d}:00" for n in range(40)]
    check(log(table(clock, clock="Uhrzeit"), mapping=Mapping(pause_s=7200.0)), 1800.0)


def test_tdms(tmp_path):
    nptdms = pytest.importorskip("nptdms")
    path, told = (
        tmp_path / "log.tdms",
        {"wf_increment": 60.0, "wf_start_time": np.datetime64(START)},
    )
    with nptdms.TdmsWriter(path) as writer:
        for name, unit, values in zip(PLAIN, UNITS, signals().T, strict=True):
            about = told | {"unit_string": unit}
            writer.write_segment([nptdms.ChannelObject("Log", name, values, properties=about)])
    check(import_files([path]))


def test_a_c_that_several_names_end_in_is_their_unit_in_every_kind_of_log(tmp_path):
    """Each channel, or each signal of a historian's export, is read on its own."""
    nptdms = pytest.importorskip("nptdms")
    values = {"front_C": np.linspace(20.0, 25.0, 8), "rear_C": np.linspace(20.0, 22.0, 8)}
    log, export = tmp_path / "log.tdms", tmp_path / "export.csv"
    with nptdms.TdmsWriter(log) as writer:
        told = {"wf_increment": 60.0}
        writer.write_segment(
            [nptdms.ChannelObject("Log", *each, properties=told) for each in values.items()]
        )
    rows = [f"{60 * n},{name},{cells[n]}" for n in range(8) for name, cells in values.items()]
    export.write_text("\n".join(["time [s],signal,value", *rows]), encoding="utf-8")
    for path in (log, export):
        (run,) = import_files([path]).runs
        assert list(run.frame) == ["time_s", "front_degC", "rear_degC"]
        np.testing.assert_allclose(run.frame["rear_degC"], values["rear_C"], atol=1e-9)


def test_mdf_with_two_clocks(tmp_path):
    asammdf = pytest.importorskip("asammdf")
    time, path = 60.0 * np.arange(40), tmp_path / "log.mf4"
    with asammdf.MDF() as log:
        channels = [
            asammdf.Signal(values, time, name=name, unit=unit)
            for name, unit, values in zip(PLAIN, UNITS, signals().T, strict=True)
        ]
        log.append(channels[:3])
        log.append(channels[3:])
        log.save(path)
    check(import_files([path]))


def test_a_table_may_begin_far_down(tmp_path):
    path = tmp_path / "log.csv"
    path.write_text(500 * "\n" + table())
    check(import_files([path]))


def test_one_column_alone_is_a_table(log, tmp_path):
    rule = Mapping(time=TimeRule(every_row_s=60.0))
    values = [21.5, 21.75, 22.0, 22.25]
    column = [["T1 [°C]"], *([value] for value in values)]
    book = workbook(tmp_path / "book.xlsx", {"day 1": column, "day 2": column})
    for comma in (True, False):
        text = "\n".join(["T1 [°C]", *(german(v) if comma else str(v) for v in values)])
        (run,) = log(text + "\n", mapping=rule).runs
        assert run.frame.to_dict("list") == {"time_s": [0.0, 60.0, 120.0, 180.0], "T1_degC": values}
    runs = import_files([book], rule).runs
    assert [run.name for run in runs] == ["book_day_1", "book_day_2"]


def test_tables_of_a_day_are_paired_by_what_tells_their_names_apart(tmp_path):
    def book(name: str, header: str, titles: list[str]) -> Path:
        sheets = {
            title: [
                ["t [s]", header],
                *([60 * n, int(title.split()[-1]) + n / 8] for n in range(4)),
            ]
            for title in titles
        }
        return workbook(tmp_path / name, sheets)

    heat = book("heat.xlsx", "T1 [°C]", ["Tag 9", "Tag 10", "Tag 11"])
    moves = book("moves.xlsx", "z [µm]", ["day 10", "day 9", "day 12"])
    found = import_files([heat, moves])
    assert [run.name for run in found.runs] == ["Tag_09", "Tag_10"]
    for number, run in zip((9, 10), found.runs, strict=True):
        assert run.frame["T1_degC"].tolist() == run.frame["z_um"].tolist()
        assert run.frame["z_um"].iloc[0] == number
    assert [note.split(": no other")[0].split(", ")[-1] for note in found.notes] == [
        "Tag 11",
        "day 12",
    ]
    with pytest.raises(BadInput, match="no name in common"):
        import_files([heat, book("other.xlsx", "z [µm]", ["day 1", "day 2"])])


def test_a_unit_for_many_leaves_time_and_other_quantities_alone(log):
    text = table(header=["T1", "T2", "Speed [rpm]", "z [um]", "q"])
    (run,) = log(text, units={"*": "degC"}).runs
    assert list(run.frame) == ["time_s", "T1_degC", "T2_degC", "speed_rpm", "z_um", "q_degC"]


@pytest.mark.parametrize("clock", ["One", "Multi", "No"])
def test_lvm(clock, log):
    def line(first: str, others: list[str]) -> list[str]:
        """Return a line with a clock for all or, where there are several, before each."""
        if clock == "Multi":
            return [cell for other in others for cell in (first, other)]
        return [first, *others]

    of_file = {"Separator": "Tab", "Decimal_Separator": ",", "X_Columns": clock}
    of_file |= {"Time_Pref": "Relative"}
    of_segment = {"Channels": ["5"], "Samples": ["40"] * 5, "Date": ["2026/03/02"] * 5}
    of_segment |= {"Time": ["07:15:00,25"] * 5, "Y_Unit_Label": UNITS, "Delta_X": ["60,0"] * 5}
    end = "***End_of_Header***\t"
    rows = [["LabVIEW Measurement\t"], *map(list, of_file.items()), [end], []]
    rows += [[key, *cells] for key, cells in of_segment.items()]
    rows += [[end], [*line("X_Value", PLAIN), "Comment"]]
    for time, values in zip(elapsed(), signals(), strict=True):
        rows.append(line("" if clock == "No" else f"{time},000000", [*map(german, values)]))
    found = log("\n".join("\t".join(row) for row in rows) + "\n", "log.lvm")
    check(found)
    assert found.pieces[0].starts == "2026-03-02 07:15:00"


def test_an_lvm_file_of_two_segments_is_two_tables(log):
    def segment(time: str) -> str:
        rows = "".join(f"{n:.6f}\t{20 + n}\n" for n in range(5))
        head = f"Channels\t1\nDate\t2026/03/02\nTime\t{time}\nY_Unit_Label\tdegC\n"
        return f"{head}***End_of_Header***\t\nX_Value\tT1\tComment\n{rows}\n"

    head = "LabVIEW Measurement\t\nSeparator\tTab\n***End_of_Header***\n\n"
    (run,) = log(head + segment("07:15:00") + segment("07:16:00"), "log.lvm").runs
    assert run.time_s.tolist() == [*range(5), *range(60, 65)]
    assert run.frame["T1_degC"].tolist() == [20, 21, 22, 23, 24] * 2


@pytest.mark.parametrize("a_line_each", [True, False])
def test_json(a_line_each, log):
    """Also the rows of a gateway that sends a value when it changes."""
    rows = [
        {"time": 60.0 * n, "T": {"front [degC]": a, "rear [degC]": b, "bed": [b, a]}}
        | ({"rpm": c} if n else {})
        for n, (a, b, c) in enumerate(signals(6)[:, [0, 1, 3]].tolist())
    ]
    lines = "\n".join(json.dumps(row) for row in rows)
    text = lines if a_line_each else json.dumps(rows, indent=1)
    found = log(text, "log.jsonl", mapping=Mapping(time=TimeRule(unit="s")))
    assert {"T bed 1", "T bed 2"} <= set(found.hints)
    (run,) = found.runs
    assert list(run.frame.columns) == ["time_s", "T_front_degC", "T_rear_degC", "speed_rpm"]
    np.testing.assert_allclose(run.frame["T_rear_degC"], signals(6)[:, 1])
    assert np.flatnonzero(run.frame["speed_rpm"].isna()).tolist() == [0]


def test_a_whole_number_that_no_double_holds_is_no_value(log):
    values = [20, 21, 10**400, 23]
    rows = [json.dumps({"t [s]": 60 * n, "T [degC]": value}) for n, value in enumerate(values)]
    (run,) = log("\n".join(rows), "log.jsonl").runs
    assert np.flatnonzero(run.frame["T_degC"].isna()).tolist() == [2]
