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

NAMES = ["time_s", "Temp_Lager_vorn_degC", "T_hinten_degC", "Halle_degC", "speed_rpm", "z_um"]
MM = np.array([1.0, 1.0, 1.0, 1.0, 1e-3])
LOCAL, ISO = "%d.%m.%Y %H:%M:%S", "%Y-%m-%dT%H:%M:%S"


def imported(path: Path, **options: object) -> Imported:
    return import_files([path], **options)


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
SECONDS = table(elapsed(), clock="Zeit [s]")
LINES = SECONDS.split("\n")
TEXTS = {
    "semicolons and commas": SECONDS,
    "tabs": table(elapsed(), clock="Zeit [s]", mark="\t"),
    "commas and points": table(elapsed(), clock="t [s]", mark=",", comma=False),
    "minutes": table(elapsed(step=1), clock="Zeit / min"),
    "hours": table([f"{n / 60:.9f}".replace(".", ",") for n in range(40)], clock="Zeit (h)"),
    "milliseconds": table(elapsed(step=60000), clock="Time, ms"),
    "local times": table(stamps(LOCAL)),
    "local times with milliseconds": table(stamps("%d.%m.%Y %H:%M:%S,250")),
    "ISO": table(stamps(ISO), clock="timestamp"),
    "colons before milliseconds": table(stamps("%d.%m.%Y %H:%M:%S:250")),
    "signs apart from numbers": SECONDS.replace(";2", ";+    2").replace(";-", ";-   "),
    "thousands set apart by points": SECONDS.replace(";6000;", ";6.000;"),
    "thousands set apart by commas": table(elapsed(), clock="t [s]", comma=False).replace(
        ";6000;", ";6,000;"
    ),
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
    "kelvin": table(
        elapsed(),
        clock="t [s]",
        header=["Temp. Lager vorn [K]", *HEADER[1:]],
        values=signals() + np.array([273.15, 0, 0, 0, 0]),
    ),
    "millimetres": table(
        elapsed(),
        clock="t [s]",
        header=[*HEADER[:4], "z [mm]"],
        values=signals() / [1, 1, 1, 1, 1e3],
    ),
}
DAY_OR_MONTH = {"month first": Mapping(time=TimeRule(day_first=False))}


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "cp1252", "utf-16"])
def test_every_encoding(encoding, tmp_path):
    path = tmp_path / "log.csv"
    path.write_bytes(SECONDS.replace("\n", "\r\n").encode(encoding))
    check(imported(path))


@pytest.mark.parametrize("form", TEXTS)
def test_every_form_of_a_text_table(form, tmp_path):
    path = tmp_path / "log.csv"
    path.write_text(TEXTS[form], encoding="utf-8")
    check(imported(path, mapping=DAY_OR_MONTH.get(form)))


def rows_of(clock: list[object]) -> list[list[object]]:
    values = signals(len(clock)).tolist()
    return [["Zeit", *HEADER], *([time, *row] for time, row in zip(clock, values, strict=True))]


@pytest.mark.parametrize("ending", [".xlsx", ".xls"])
def test_a_workbook_with_a_cover_and_two_sheets(ending, tmp_path):
    clock: list[object] = [START + dt.timedelta(minutes=n) for n in range(40)]
    rows = rows_of(clock)
    parts = {
        "Deckblatt": [["Messung"]],
        "Temperaturen": [["Messung 7"], [], *(row[:4] for row in rows)],
        "Achsen": [[row[0], *row[4:]] for row in rows],
    }
    check(imported(workbook(tmp_path / f"log{ending}", parts)))


def test_a_heading_that_is_merged_over_two_rows(tmp_path):
    rows = rows_of([START + dt.timedelta(minutes=n) for n in range(40)])
    over = [rows[0][0], "Temperaturen", *(len(HEADER) - 1) * [None]]
    check(imported(workbook(tmp_path / "log.xlsx", {"Log": [over, [None, *HEADER], *rows[1:]]})))


def test_a_hidden_sheet_is_left_out_and_told(tmp_path):
    rows = rows_of([START + dt.timedelta(minutes=n) for n in range(40)])
    path = workbook(tmp_path / "log.xlsx", {"Log": rows, "old": rows})
    book = openpyxl.load_workbook(path)
    book["old"].sheet_state = "hidden"
    book.save(path)
    found = imported(path)
    check(found)
    assert found.notes == (f"{path}, Log: left out: old: is hidden",)


def test_a_wire_that_broke_is_missing_and_told(tmp_path):
    values = signals()
    values[15:, 1] = -999.0
    path = tmp_path / "log.csv"
    path.write_text(table(elapsed(), clock="t [s]", values=values), encoding="utf-8")
    found = imported(path)
    (run,) = found.runs
    np.testing.assert_allclose(run.frame["T_hinten_degC"][:15], signals()[:15, 1])
    assert run.frame["T_hinten_degC"][15:].isna().all()
    told = "row 17, column T hinten (degC): -999 degC is outside -60..400 degC: it and 24 more are"
    assert any(told in note for note in found.notes)


@pytest.mark.parametrize("sign", ["****", "+OVER", "?", "-1.#IND", "BURNOUT", "#NV"])
def test_signs_of_no_value(sign, tmp_path):
    path = tmp_path / "log.csv"
    path.write_text(SECONDS.replace(";20,75;", f";{sign};"), encoding="utf-8")
    assert np.isnan(imported(path).runs[0].frame["T_hinten_degC"][0])


@pytest.mark.parametrize("decimal", [",", "."])
def test_thousands_are_set_apart_further_down_than_the_decimal_mark_is_looked_for(
    decimal, tmp_path
):
    values = signals(500)
    values[:490, 3] = 0.0
    path = tmp_path / "log.csv"
    text = table(elapsed(500), clock="t [s]", values=values, comma=decimal == ",")
    text = text.replace(";6000;", ";6.000;" if decimal == "," else ";6,000;")
    path.write_text(text, encoding="utf-8")
    assert imported(path).runs[0].frame["speed_rpm"].tolist() == values[:, 3].tolist()


@pytest.mark.parametrize("names", [("Zeit", "Zeit"), ("t [s]", "t2 [s]")])
def test_blocks_side_by_side_have_their_own_clocks(names, tmp_path):
    local = names[0] == "Zeit"
    clock = [START + dt.timedelta(minutes=n) if local else 60.0 * n for n in range(40)]
    head = [names[0], HEADER[0], None, names[1], HEADER[4]]
    rows = [
        [clock[n], 20.0 + n, None, *((clock[2 * n], float(2 * n)) if n < 20 else (None, None))]
        for n in range(40)
    ]
    (run,) = imported(workbook(tmp_path / "log.xlsx", {"Log": [head, *rows]})).runs
    frame = run.frame.dropna()
    assert frame["z_um"].tolist() == (frame["time_s"] / 60.0).tolist() == list(range(0, 40, 2))


def test_tables_of_a_fast_recorder_lose_no_rows(tmp_path):
    clock = [f"{0.0005 * n:.4f}" for n in range(40)]
    for name, column in (("T", HEADER[0]), ("z", HEADER[4])):
        text = "\n".join([f"t [s];{column}", *(f"{now};{n}" for n, now in enumerate(clock))])
        (tmp_path / f"{name}.csv").write_text(text, encoding="utf-8")
    (run,) = import_files([tmp_path / "T.csv", tmp_path / "z.csv"]).runs
    assert run.frame.iloc[:, 1].tolist() == run.frame.iloc[:, 2].tolist() == list(range(40))


def test_an_inch_is_a_length_where_its_name_says_so(tmp_path):
    path = tmp_path / "log.csv"
    path.write_text("time [s],Tool length [inch],disp_z [inch]\n0,5,0\n10,5,0.001\n20,5,0.002\n")
    frame = import_files([path]).runs[0].frame
    assert frame["Tool_length_mm"].tolist() == [127.0] * 3
    assert frame["disp_z_um"].tolist() == [0.0, 25.4, 50.8]


def test_an_axis_makes_a_displacement_of_a_position(tmp_path):
    path, header = tmp_path / "log.csv", "Pos Z [mm]"
    text = table(elapsed(), clock="t [s]", header=[*HEADER[:4], header], values=signals() * MM)
    path.write_text(text, encoding="utf-8")
    frame = import_files([path], axes={header: "-Z"}).runs[0].frame
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


@pytest.mark.parametrize("name", ["T [°C]", "T2 [°C]", "T2"])
def test_a_temperature_between_others_begins_no_block(name, tmp_path):
    path = tmp_path / "log.csv"
    header = [HEADER[4], name, *HEADER[1:4]]
    text = table(elapsed(), clock="t [s]", header=header, values=signals()[:, [4, 0, 1, 2, 3]])
    path.write_text(text, encoding="utf-8")
    (run,) = imported(path, units={"T2": "degC"} if name == "T2" else {}).runs
    assert run.frame.iloc[:, 2].tolist() == signals()[:, 0].tolist()


def test_of_several_speeds_none_is_known_and_that_is_told(tmp_path):
    path = tmp_path / "log.csv"
    header = [HEADER[0], "S set [rpm]", HEADER[2], "S act [rpm]", HEADER[4]]
    path.write_text(table(elapsed(), clock="t [s]", header=header), encoding="utf-8")
    (note,) = imported(path).notes
    assert note.startswith('no speed is known: name = "speed"')
    assert note.endswith("S set [rpm], S act [rpm]")


def test_rows_of_whole_seconds_are_spread_and_told(tmp_path):
    clock = [(START + dt.timedelta(seconds=n // 4)).strftime(LOCAL) for n in range(40)]
    path = tmp_path / "log.csv"
    path.write_text(table(clock), encoding="utf-8")
    found = imported(path)
    np.testing.assert_allclose(found.runs[0].time_s, np.arange(40) / 4.0)
    assert "30 rows share the previous row's time stamp" in found.notes[0]


def test_clocks_set_back_are_undone_with_a_zone(tmp_path):
    begin = pd.Timestamp("2026-10-25 01:30", tz="Europe/Berlin")
    local = [(begin + pd.Timedelta(minutes=5 * n)).strftime(LOCAL) for n in range(40)]
    path = tmp_path / "log.csv"
    path.write_text(table(local), encoding="utf-8")
    check(imported(path, mapping=Mapping(time=TimeRule(timezone="Europe/Berlin"))), 300.0)


def test_clocks_put_forward_look_like_a_pause_and_are_told(tmp_path):
    begin = pd.Timestamp("2026-03-29 01:30", tz="Europe/Berlin")
    local = [(begin + pd.Timedelta(minutes=5 * n)).strftime(LOCAL) for n in range(40)]
    path = tmp_path / "log.csv"
    path.write_text(table(local), encoding="utf-8")
    (note,) = imported(path).notes
    assert "the pause from 2026-03-29 01:55:00 may be no pause" in note
    check(imported(path, mapping=Mapping(time=TimeRule(timezone="Europe/Berlin"))), 300.0)


def test_a_night_is_passed_by_times_of_day(tmp_path):
    clock = [f"{(22 + n // 2) % 24:02d}:{30 * (n % 2):02d}:00" for n in range(40)]
    path = tmp_path / "log.csv"
    path.write_text(table(clock, clock="Uhrzeit"), encoding="utf-8")
    check(imported(path, mapping=Mapping(pause_s=7200.0)), 1800.0)


def test_tdms(tmp_path):
    nptdms = pytest.importorskip("nptdms")
    path, units = tmp_path / "log.tdms", ["°C", "degC", "°C", "1/min", "µm"]
    names = ["Temp. Lager vorn", "T hinten", "Halle", "Drehzahl", "z"]
    with nptdms.TdmsWriter(path) as writer:
        for name, unit, values in zip(names, units, signals().T, strict=True):
            told = {
                "unit_string": unit,
                "wf_increment": 60.0,
                "wf_start_time": np.datetime64(START),
            }
            writer.write_segment([nptdms.ChannelObject("Log", name, values, properties=told)])
    check(imported(path))


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
        (run,) = imported(path).runs
        assert list(run.frame) == ["time_s", "front_degC", "rear_degC"]
        np.testing.assert_allclose(run.frame["rear_degC"], values["rear_C"], atol=1e-9)


def test_mdf_with_two_clocks(tmp_path):
    asammdf = pytest.importorskip("asammdf")
    units = ["°C", "degC", "°C", "1/min", "µm"]
    names = ["Temp. Lager vorn", "T hinten", "Halle", "Drehzahl", "z"]
    time, path = 60.0 * np.arange(40), tmp_path / "log.mf4"
    with asammdf.MDF() as log:
        channels = [
            asammdf.Signal(values, time, name=name, unit=unit)
            for name, unit, values in zip(names, units, signals().T, strict=True)
        ]
        log.append(channels[:3])
        log.append(channels[3:])
        log.save(path)
    check(imported(path))


@pytest.mark.parametrize("ending", [".tdms", ".mf4", ".xlsx", ".xls", ".ods"])
def test_a_damaged_file_is_refused_in_one_line(ending, tmp_path):
    from measurement.errors import BadInput

    path = tmp_path / f"log{ending}"
    path.write_bytes(b"\x00\x01damaged" * 30)
    with pytest.raises(BadInput) as caught:
        imported(path)
    assert str(caught.value).startswith(f"{path}: ")
    assert "\n" not in str(caught.value)


def test_one_column_alone_is_a_table(tmp_path):
    rule = Mapping(time=TimeRule(every_row_s=60.0))
    values = [21.5, 21.75, 22.0, 22.25]
    column = [["T1 [°C]"], *([value] for value in values)]
    book = workbook(tmp_path / "book.xlsx", {"day 1": column, "day 2": column})
    for comma in (True, False):
        text = "\n".join(["T1 [°C]", *(german(v) if comma else str(v) for v in values)])
        (tmp_path / "log.csv").write_text(text + "\n", encoding="utf-8")
        (run,) = import_files([tmp_path / "log.csv"], rule).runs
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


def test_a_unit_for_many_leaves_time_and_other_quantities_alone(tmp_path):
    text = table(elapsed(), clock="Zeit [s]", header=["T1", "T2", "Speed [rpm]", "z [um]", "q"])
    (tmp_path / "log.csv").write_text(text, encoding="utf-8")
    (run,) = import_files([tmp_path / "log.csv"], units={"*": "degC"}).runs
    assert list(run.frame) == ["time_s", "T1_degC", "T2_degC", "speed_rpm", "z_um", "q_degC"]


@pytest.mark.parametrize("clock", ["One", "Multi", "No"])
def test_lvm(clock, tmp_path):
    units = ["°C", "degC", "°C", "1/min", "µm"]
    names = [header.partition(" [")[0].partition(" (")[0] for header in HEADER]
    values, times = signals(), [f"{float(time):.6f}" for time in elapsed()]
    columns = list(zip(names, values.T, strict=True))
    lines = []
    for row, time in enumerate(times):
        told = [f"{column[row]:g}" for _, column in columns]
        firsts = {"One": [time], "No": [""], "Multi": []}[clock]
        cells = [cell for value in told for cell in (time, value)] if clock == "Multi" else told
        lines.append([*firsts, *cells])
    labels = ["X_Value", *names]
    if clock == "Multi":
        labels = [label for name in names for label in ("X_Value", name)]
    of_file = {"Separator": "Tab", "Decimal_Separator": ",", "X_Columns": clock}
    of_file |= {"Time_Pref": "Relative"}
    of_segment = {"Channels": ["5"], "Samples": ["40"] * 5, "Date": ["2026/03/02"] * 5}
    of_segment |= {"Time": ["07:15:00,25"] * 5, "Y_Unit_Label": units, "Delta_X": ["60,0"] * 5}
    end = "***End_of_Header***\t"
    rows = [["LabVIEW Measurement\t"], *map(list, of_file.items()), [end], []]
    rows += [[key, *cells] for key, cells in of_segment.items()] + [[end], [*labels, "Comment"]]
    text = "\n".join("\t".join(row) for row in rows) + "\n"
    text += "\n".join("\t".join(row).replace(".", ",") for row in lines) + "\n"
    path = tmp_path / "log.lvm"
    path.write_text(text, encoding="utf-8")
    found = imported(path)
    check(found)
    assert found.pieces[0].starts == "2026-03-02 07:15:00"


def test_an_lvm_file_of_two_segments_is_two_tables(tmp_path):
    def segment(time: str) -> str:
        rows = "".join(f"{n:.6f}\t{20 + n}\n" for n in range(5))
        head = f"Channels\t1\nDate\t2026/03/02\nTime\t{time}\nY_Unit_Label\tdegC\n"
        return f"{head}***End_of_Header***\t\nX_Value\tT1\tComment\n{rows}\n"

    path = tmp_path / "log.lvm"
    head = "LabVIEW Measurement\t\nSeparator\tTab\n***End_of_Header***\n\n"
    path.write_text(head + segment("07:15:00") + segment("07:16:00"))
    (run,) = imported(path).runs
    assert run.time_s.tolist() == [*range(5), *range(60, 65)]
    assert run.frame["T1_degC"].tolist() == [20, 21, 22, 23, 24] * 2


def test_a_table_with_a_row_for_each_value(tmp_path):
    lines = ["timestamp;tag;value;unit;quality"]
    units = ["°C", "degC", "°C", "1/min", "µm"]
    for time, row in zip(stamps(LOCAL), signals(), strict=True):
        for header, value, unit in zip(HEADER, row, units, strict=True):
            name = header.partition(" [")[0].partition(" (")[0]
            lines.append(f"{time};{name};{german(value)};{unit};GOOD")
    path = tmp_path / "export.csv"
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    check(imported(path))


@pytest.mark.parametrize("a_line_each", [True, False])
def test_json(a_line_each, tmp_path):
    """Also the rows of a gateway that sends a value when it changes."""
    rows = [
        {"time": 60.0 * n, "T": {"front [degC]": a, "rear [degC]": b, "bed": [b, a]}}
        | ({"rpm": c} if n else {})
        for n, (a, b, c) in enumerate(signals(6)[:, [0, 1, 3]].tolist())
    ]
    path = tmp_path / "log.jsonl"
    lines = "\n".join(json.dumps(row) for row in rows)
    path.write_text(lines if a_line_each else json.dumps(rows, indent=1), encoding="utf-8")
    found = imported(path, mapping=Mapping(time=TimeRule(unit="s")))
    assert {"T bed 1", "T bed 2"} <= set(found.hints)
    (run,) = found.runs
    assert list(run.frame.columns) == ["time_s", "T_front_degC", "T_rear_degC", "speed_rpm"]
    np.testing.assert_allclose(run.frame["T_rear_degC"], signals(6)[:, 1])
    assert np.flatnonzero(run.frame["speed_rpm"].isna()).tolist() == [0]
    path.write_text(lines.replace("60.0", "60.0}", 1), encoding="utf-8")
    with pytest.raises(BadInput, match="row 2: is no JSON: Extra data"):
        imported(path)


@pytest.mark.parametrize(
    ("text", "problem"),
    [
        ("{}", "no table"),
        ("[{}, 7]", "row 2: is no JSON object"),
        ('{"T 1": 20, "T  1": 21}', r"row 1: holds 'T 1' twice \(apart from blanks\)"),
        ('{"T 1": 20, "T": [21]}', r"row 1: holds 'T 1' twice \(apart from blanks\)"),
        # Which of the two gives up first is the interpreter's matter.
        ('{"a":' * 20_000 + "1" + "}" * 20_000, "is no JSON: maximum recursion|too deep"),
    ],
)
def test_json_that_is_no_table_is_refused(text, problem, tmp_path):
    path = tmp_path / "log.json"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(BadInput, match=problem):
        imported(path)


def test_a_whole_number_that_no_double_holds_is_no_value(tmp_path):
    path = tmp_path / "log.jsonl"
    values = [20, 21, 10**400, 23]
    rows = [json.dumps({"t [s]": 60 * n, "T [degC]": value}) for n, value in enumerate(values)]
    path.write_text("\n".join(rows), encoding="utf-8")
    (run,) = imported(path).runs
    assert np.flatnonzero(run.frame["T_degC"].isna()).tolist() == [2]


def test_fahrenheit(tmp_path):
    values = signals()
    values[:, :3] = values[:, :3] * 1.8 + 32.0
    header = [name.replace("°C", "°F").replace("degC", "degF") for name in HEADER]
    path = tmp_path / "log.csv"
    path.write_text(table(elapsed(), clock="t [s]", header=header, values=values), encoding="utf-8")
    (run,) = imported(path).runs
    np.testing.assert_allclose(run.frame[NAMES[1:]], signals(), atol=1e-3)
