"""A table of bad inputs: each is refused in one line that says where, what, and what to do."""

import re

import pytest

from measurement.errors import BadInput
from measurement.importing.log import import_files
from measurement.importing.mapping import Mapping, TimeRule
from tests.measurement.importing.made import HEADER, elapsed, signals, stamps, table, workbook
from tests.refusing import refusal

SECONDS = table()
LINES = SECONDS.split("\n")
LOCAL = table(stamps("%d.%m.%Y %H:%M:%S"))
TWICE = [*stamps("%d.%m.%Y %H:%M", 40, 300.0)[:39], "02.03.2026 10:25"]
OIL = {"header": ["Öl [°C]"], "values": signals()[:, :1]}

LVM_HEAD = "LabVIEW Measurement\t\nSeparator\tTab\n***End_of_Header***\n\nChannels\t1\n"
LVM = f"{LVM_HEAD}Y_Unit_Label\tdegC\n***End_of_Header***\nX_Value\tT1\tComment\n"


def changed(row: int, old: str, new: str, text: str = SECONDS) -> str:
    lines = text.split("\n")
    assert old in lines[row - 1]
    lines[row - 1] = lines[row - 1].replace(old, new, 1)
    return "\n".join(lines)


CASES = [
    ("", "is empty; a header and data rows are needed"),
    ("\n \n", "is empty"),
    ("\0\1\2PNG\0", "is no text"),
    ("Sehr geehrte Damen und Herren\nanbei das Protokoll\n", "holds no table"),
    (LINES[0], "no row of numbers"),
    ("\n".join(LINES[1:]), "row 1: holds numbers; a header with names"),
    (changed(5, "20,53", "defekt"), "row 5, column Halle [°C]: 'defekt' is not a number"),
    (changed(9, ";6000", ";6000;1"), "row 9: has 7 cells; the others"),
    (changed(9, ";6000", ""), "row 9: has 5 cells; the others have 6"),
    (changed(2, ";0;", ";"), "row 2: has 5 cells; the others have 6"),
    ("time [s];tag;value\n0;T1;21,5\n0;;21,5\n1;T1;21,6\n", "row 3, column tag: is missing;"),
    ("t [s],T1 [°C]\n0,5,21,3\n1,5,21,4\n2,5,21,5\n", "decimal commas need another separator"),
    (changed(4, "21,", "21."), "stand in it: one decimal mark is needed"),
    # A point among numbers whose points set thousands apart.
    (SECONDS.replace(";6000;", ";6.000,0;").replace("\n120;", "\n120.5;"), "one decimal mark"),
    # The clock.
    (changed(1, "Zeit [s]", "Nr"), "none of Nr, Temp."),
    (changed(1, " [s]", ""), "column Zeit: no unit: say it, as in --unit"),
    (changed(1, "[s]", "[furlong]"), "'furlong' is no unit of time"),
    (changed(6, "240;", ";"), "row 6, column Zeit [s]: is missing"),
    (
        table([f"{8000 + 60 * n - (3600 if n > 2 else 0)}" for n in range(9)], clock="Zeit [s]"),
        "row 5, column Zeit [s]: 4580 s is before 8120 s, the last row; if the recorder began "
        "anew, make two files of it; if clocks were set back by an hour, add 3600 s from there on",
    ),
    (changed(6, "240;", "100;"), "row 6, column Zeit [s]: 100 s is before 180 s"),
    (table(TWICE), "row 41, column Zeit: has the same time as the previous row, 2026-03-02 10:25"),
    (changed(6, "07:19:00", "06:19:00", LOCAL), "--timezone Europe/Berlin mends it"),
    (changed(6, "07:19:00", "06:28:00", LOCAL), "--timezone Europe/Berlin mends it"),
    (changed(6, "02.03.2026", "31.02.2026", LOCAL), "row 6, column Zeit: '31.02.2026 07:19:00'"),
    (table(stamps("%d/%m/%Y %H:%M:%S")), "can be read in two ways: use --day-first or"),
    (table(elapsed(1), clock="Zeit [s]"), "has no run of 2 rows or more"),
    # Names and units.
    (changed(1, HEADER[1], ""), "column 3: has values but no name"),
    (changed(1, HEADER[1], HEADER[0]), f"column 3: '{HEADER[0]}' is the name of an earlier column"),
    (changed(1, "Halle [°C]", "Halle [K]"), "20.5 K (-252.65 degC) is outside -60..400 degC: is K"),
    (
        changed(7, "20,56", "401,5", changed(8, "20,56", "402")),
        "row 7, column Halle [°C]: 401.5 °C",
    ),
    (
        "Zeit [s];T1;T2\n0;20;21\n1;20;21\n2;20;21\n",
        "column T1: no column can be placed: it has no",
    ),
    # Tables that do not go together.
    ((LOCAL, LOCAL), "overlaps 0.csv in time, with the same columns"),
    ((LOCAL, table(**OIL)), "counts from an unknown start, while"),
    ((LOCAL, table(stamps("%d.%m.2025 %H:%M:%S"), **OIL)), "begins after another table has ended"),
    ((SECONDS, table(header=[HEADER[2]], values=OIL["values"])), "Halle_degC is in another table"),
    # LabVIEW's files, which are told by their first line.
    (LVM_HEAD, "holds no segment with a header and rows"),
    (LVM, "holds no table with a header and data rows"),
    (f"{LVM}0.0\t21\nnoon\t22\n", "segment 1: its clock cannot be read"),
    (f"{LVM}0\t20\n1\t21\n\t99\n3\t23\n", "segment 1: row 3, column time [s]: is missing; every"),
    (f"{LVM}0.0\t21\t\t5\t7\n", "segment 1: a row has 5 cells, its header 3"),
]
JSON = [
    ("{}", "no table"),
    ("[{}, 7]", "row 2: is no JSON object"),
    ('{"T": 1}\n{"T": 1}}\n', "row 2: is no JSON: Extra"),
    ('{"T 1": 20, "T  1": 21}', "row 1: holds 'T 1' twice (apart from blanks)"),
    ('{"T 1": 20, "T": [21]}', "row 1: holds 'T 1' twice (apart from blanks)"),
    # What gives up first, and so says it, is the interpreter's matter.
    ('{"a":' * 20_000 + "1" + "}" * 20_000, ""),
]
DAMAGED = [("\0\1damaged" * 30, ending) for ending in (".tdms", ".mf4", ".xlsx", ".xls", ".ods")]


@pytest.mark.parametrize(
    ("texts", "told", "ending"),
    [
        *(pytest.param(texts, told, ".csv", id=told) for texts, told in CASES),
        *(pytest.param(text, told, ".json", id=f"json {told}") for text, told in JSON),
        *(pytest.param(text, "", ending, id=ending) for text, ending in DAMAGED),
    ],
)
def test_bad_input_is_refused_in_one_line(texts, told, ending, tmp_path):
    paths = []
    for number, text in enumerate([texts] if isinstance(texts, str) else texts):
        paths.append(tmp_path / f"{number}{ending}")
        paths[-1].write_text(text, encoding="utf-8")
    said = refusal(import_files, paths)
    assert told in said
    assert any(path.stem in said for path in paths)


def test_a_workbook_without_a_table_is_refused(tmp_path):
    path = workbook(tmp_path / "cover.xlsx", {"Deckblatt": [["Messung 7"], ["Müller", "Halle"]]})
    assert "cover.xlsx: Deckblatt: holds no table" in refusal(import_files, [path])


@pytest.mark.parametrize("there", ["Zeit [s]", "Nr"])
def test_a_column_of_time_that_is_not_there_is_refused(there, log):
    rule = TimeRule(columns=["Zeti"])
    with pytest.raises(BadInput, match=f"time: no column is called 'Zeti': .*{re.escape(there)}"):
        log(SECONDS.replace("Zeit [s]", there), mapping=Mapping(time=rule))


def test_no_file_is_refused():
    assert "import: files: none was given" in refusal(import_files, [])
