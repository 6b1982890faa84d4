"""A table of bad inputs: each is refused in one line that says where, what, and what to do."""

import re
from typing import NamedTuple

import pytest

from measurement.errors import BadInput
from measurement.importing.log import import_files
from measurement.importing.mapping import Mapping, TimeRule
from tests.measurement.importing.made import HEADER, elapsed, signals, stamps, table, workbook

SECONDS = table(elapsed(), clock="Zeit [s]")
LINES = SECONDS.split("\n")
LOCAL = table(stamps("%d.%m.%Y %H:%M:%S"))

LVM = (
    "LabVIEW Measurement\t\nSeparator\tTab\n***End_of_Header***\n\nChannels\t1\n"
    "Y_Unit_Label\tdegC\n***End_of_Header***\nX_Value\tT1\tComment\n"
)


class Bad(NamedTuple):
    """What is in the files, and what the refusal says after the file's name."""

    texts: tuple[str, ...]
    told: str


def changed(row: int, old: str, new: str, text: str = SECONDS) -> str:
    lines = text.split("\n")
    assert old in lines[row - 1]
    lines[row - 1] = lines[row - 1].replace(old, new, 1)
    return "\n".join(lines)


def with_header(header: str) -> str:
    return "\n".join([header, *LINES[1:]])


CASES = {
    "empty": Bad(("",), "is empty; a header and data rows are needed"),
    "blank": Bad(("\n \n",), "is empty"),
    "binary": Bad(("\0\1\2PNG\0",), "is no text"),
    "prose": Bad(("Sehr geehrte Damen und Herren\nanbei das Protokoll\n",), "holds no table"),
    "only a header": Bad((LINES[0],), "no row of numbers"),
    "no header": Bad(("\n".join(LINES[1:]),), "row 1: holds numbers; a header with names"),
    "a word among numbers": Bad(
        (changed(5, "20,53", "defekt"),), "row 5, column Halle [°C]: 'defekt' is not a number"
    ),
    "a cell too many": Bad((changed(9, ";6000", ";6000;1"),), "row 9: has 7 cells; the others"),
    "a cell too few": Bad((changed(9, ";6000", ""),), "row 9: has 5 cells; the others have 6"),
    "a value without a name": Bad(
        ("time [s];tag;value\n0;T1;21,5\n0;;21,5\n1;T1;21,6\n",),
        "row 3, column tag: is missing; every value needs the name of its signal",
    ),
    "lvm cut in its header": Bad(
        ("LabVIEW Measurement\t\nSeparator\tTab\n***End_of_Header***\nChannels\t1\n",),
        "holds no segment with a header and rows",
    ),
    "lvm without a row": Bad((LVM,), "holds no table with a header and data rows"),
    "lvm with a word for a time": Bad(
        (f"{LVM}0.0\t21\nnoon\t22\n",), "segment 1: its clock cannot be read"
    ),
    "lvm without a time in a row": Bad(
        (f"{LVM}0\t20\n1\t21\n\t99\n3\t23\n",),
        "segment 1: row 3, column time [s]: is missing; every row needs a time",
    ),
    "lvm with a row too wide": Bad(
        (f"{LVM}0.0\t21\t\t5\t7\n",), "segment 1: a row has 5 cells, its header 3"
    ),
    "the first row cut": Bad((changed(2, ";0;", ";"),), "row 2: has 5 cells; the others have 6"),
    "decimal commas between commas": Bad(
        ("t [s],T1 [°C]\n0,5,21,3\n1,5,21,4\n2,5,21,5\n",), "decimal commas need another separator"
    ),
    "two decimal marks": Bad(
        (changed(4, "21,", "21."),), "stand in it: one decimal mark is needed"
    ),
    "no time": Bad((with_header(LINES[0].replace("Zeit [s]", "Nr")),), "none of Nr, Temp."),
    "time without a unit": Bad(
        (with_header(LINES[0].replace(" [s]", "")),), "column Zeit: no unit: say it, as in --unit"
    ),
    "time in furlongs": Bad(
        (with_header(LINES[0].replace("[s]", "[furlong]")),), "'furlong' is no unit of time"
    ),
    "time missing": Bad((changed(6, "240;", ";"),), "row 6, column Zeit [s]: is missing"),
    "time goes back": Bad(
        (changed(6, "240;", "100;"),), "row 6, column Zeit [s]: 100 s is before 180 s"
    ),
    "the same minute twice": Bad(
        (table([*stamps("%d.%m.%Y %H:%M", 40, 300.0)[:39], "02.03.2026 10:25"]),),
        "row 41, column Zeit: has the same time as the previous row, 2026-03-02 10:25:00",
    ),
    "clocks set back": Bad(
        (changed(6, "07:19:00", "06:19:00", LOCAL),), "--timezone Europe/Berlin mends it"
    ),
    "no such day": Bad(
        (changed(6, "02.03.2026", "31.02.2026", LOCAL),),
        "row 6, column Zeit: '31.02.2026 07:19:00'",
    ),
    "day or month": Bad(
        (table(stamps("%d/%m/%Y %H:%M:%S")),), "can be read in two ways: use --day-first or"
    ),
    "a value with no name": Bad(
        (with_header(LINES[0].replace("T hinten (degC)", "")),), "column 3: has values but no name"
    ),
    "two columns of one name": Bad(
        (with_header(LINES[0].replace("T hinten (degC)", HEADER[0])),),
        "column 3: 'Temp. Lager vorn [°C]' is the name of an earlier column",
    ),
    "celsius called kelvin": Bad(
        (with_header(LINES[0].replace("Halle [°C]", "Halle [K]")),),
        "row 2, column Halle [K]: 20.5 K (-252.65 degC) is outside -60..400 degC: is K its unit?",
    ),
    "points among thousands with points": Bad(
        (SECONDS.replace(";6000;", ";6.000,0;").replace("\n120;", "\n120.5;"),),
        "both '21,39' and '120.5' stand in it: one decimal mark is needed",
    ),
    "tenths of a degree": Bad(
        (changed(7, "20,56", "401,5", changed(8, "20,56", "402")),),
        "row 7, column Halle [°C]: 401.5 °C is outside -60..400 degC: is °C its unit?",
    ),
    "no unit at all": Bad(
        ("Zeit [s];T1;T2\n0;20;21\n1;20;21\n2;20;21\n",),
        "column T1: no column can be placed: it has no unit; by its name and values perhaps degC",
    ),
    "too short": Bad((table(elapsed(1), clock="Zeit [s]"),), "has no run of 2 rows or more"),
    "overlapping logs": Bad((LOCAL, LOCAL), "overlaps 0.csv in time, with the same columns"),
    "dates beside a count": Bad(
        (LOCAL, table(elapsed(), clock="t [s]", header=["Öl [°C]"], values=signals()[:, :1])),
        "counts from an unknown start, while",
    ),
    "clocks that never meet": Bad(
        (
            LOCAL,
            table(
                [time.replace("2026", "2025") for time in stamps("%d.%m.%Y %H:%M:%S")],
                header=["Öl [°C]"],
                values=signals()[:, :1],
            ),
        ),
        "begins after another table has ended",
    ),
    "one name in two tables": Bad(
        (SECONDS, table(elapsed(), clock="t [s]", header=[HEADER[2]], values=signals()[:, :1])),
        "Halle_degC is in another table, too",
    ),
}


@pytest.mark.parametrize("case", CASES)
def test_bad_input_is_refused_in_one_line(case, tmp_path):
    paths = []
    for number, text in enumerate(CASES[case].texts):
        paths.append(tmp_path / f"{number}.csv")
        paths[-1].write_text(text, encoding="utf-8")
    with pytest.raises(BadInput) as caught:
        import_files(paths)
    said = str(caught.value)
    assert CASES[case].told in said
    assert "\n" not in said
    assert any(path.stem in said for path in paths)


def test_a_workbook_without_a_table_is_refused(tmp_path):
    path = workbook(tmp_path / "cover.xlsx", {"Deckblatt": [["Messung 7"], ["Müller", "Halle"]]})
    with pytest.raises(BadInput, match=r"cover\.xlsx: Deckblatt: holds no table"):
        import_files([path])


@pytest.mark.parametrize("there", ["Zeit [s]", "Nr"])
def test_a_column_of_time_that_is_not_there_is_refused(there, tmp_path):
    path = tmp_path / "log.csv"
    path.write_text(SECONDS.replace("Zeit [s]", there), encoding="utf-8")
    rule = TimeRule(columns=["Zeti"])
    with pytest.raises(BadInput, match=f"time: no column is called 'Zeti': .*{re.escape(there)}"):
        import_files([path], Mapping(time=rule))


def test_no_file_is_refused():
    with pytest.raises(BadInput, match="import: files: none was given"):
        import_files([])
