"""Reading and writing run files."""

import math
import re

import numpy as np
import pandas as pd
import pytest
from hypothesis import given
from hypothesis import strategies as st

from measurement import runs
from measurement.errors import BadInput
from measurement.importing.log import import_files
from measurement.runs import Run, read_run, write_run
from tests.refusing import refusal

GOOD = """time_s,speed_rpm,T1_degC,S1_um
0,1000,20.5,0
10.5,1000,,1.25
20,0,NaN,-3e-1
"""


def test_a_run_with_uneven_sampling_and_missing_values(tmp_path):
    path = tmp_path / "monday.csv"
    path.write_text(GOOD)
    run = read_run(path)
    assert run.name == "monday"
    assert run.time_s.tolist() == [0.0, 10.5, 20.0]
    assert run.temperatures == ["T1_degC"]
    assert run.displacements == ["S1_um"]
    assert run.frame["S1_um"].tolist() == [0.0, 1.25, -0.3]
    assert run.frame["T1_degC"].isna().tolist() == [False, True, True]
    assert (run.frame.dtypes == np.float64).all()


@pytest.mark.parametrize(
    "variant",
    [
        "\ufeff" + GOOD,
        GOOD.replace("\n", "\r\n"),
        GOOD.replace("\n", "\r"),
        GOOD + "\n\n",
        GOOD.rstrip("\n"),
        GOOD.replace(",", " , "),
        GOOD.replace("1.25", '"1.25"').replace("speed_rpm", '"speed_rpm"'),
    ],
)
def test_harmless_differences_of_writing_change_nothing(tmp_path, variant):
    path = tmp_path / "run.csv"
    path.write_text(GOOD)
    plain = read_run(path).frame
    path.write_bytes(variant.encode())
    pd.testing.assert_frame_equal(read_run(path).frame, plain)


@pytest.mark.parametrize(
    ("content", "expected"),
    [
        ("", "is empty"),
        ("time_s,T1_degC\n", "row 2: there are no data rows"),
        ('time_s,"T1_degC"\n', "row 2: there are no data rows"),
        ("T1_degC,time_s\n1,2\n", "row 1, first column: is 'T1_degC'; it must be time_s"),
        ("time_s;T1_degC\n1;2\n", "row 1, first column: is 'time_s;T1_degC'; it must be time_s"),
        ("time_s,T1\n1,2\n", "row 1, column 2: 'T1' has no known unit"),
        ("time_s,a_um,a_um\n1,2,3\n", "row 1, column 3: 'a_um' is also column 2"),
        ("time_s,\n1,2\n", "row 1, column 2: '' has no known unit"),
        ("time_s,a\tb_um\n1,2\n", "row 1, column 2: 'a\\tb_um' holds a character"),
        ("time_s,a_um\n1,2\n2\n", "row 3: has 1 cell; the header names 2 columns"),
        ("time_s,a_um\n1,2\n\n3,4\n", "row 3: is blank; the header names 2 columns"),
        ("time_s,a_um\n1,2,3\n", "row 2: has 3 cells; the header names 2 columns"),
        ("time_s,a_um\n1,2\n2,x3\n", "row 3, column a_um: 'x3' is not a number"),
        ("time_s,a_um\n1,True\n2,False\n", "row 2, column a_um: 'True' is not a number"),
        ("time_s,a_um\n1,1_0\n", "row 2, column a_um: '1_0' is not a number"),
        ("time_s,a_um\n1,\xa0\n", "row 2, column a_um: '\\xa0' is not a number"),
        ("time_s,a_um\n1,0x10\n", "row 2, column a_um: '0x10' is not a number"),
        ("time_s,a_um\n1,\u0661\n", "row 2, column a_um: '\u0661' is not a number"),
        ('time_s,a_um\n1,"2,5"\n', "row 2, column a_um: '2,5' is not a number"),
        ('time_s,a_um\n1,"2\n', "row 2: is not a CSV row"),
        ("time_s,a_um\n1,inf\n", "row 2, column a_um: inf is infinite"),
        ("time_s,a_um\n1,1e999\n", "row 2, column a_um: inf is infinite"),
        ("time_s,a_um\n2,2\n1,2\n", "row 3, column time_s: 1.0 is not after 2.0"),
        (
            "time_s,a_um\n4000,2\n460,2\n",
            "row 3, column time_s: 460.0 is not after 4000.0, the previous row; time must grow "
            "from row to row; if the clock was set back by an hour, add 3600 s from there on",
        ),
        ("time_s,a_um\n2,2\n3,2\n2e8,2\n", "row 4, column time_s: 2e+08 after 3, the previous row"),
        ("time_s,a_um\n1,2\n,2\n", "row 3, column time_s: is missing"),
        ("time_s\n1\n\n3\n", "row 3, column time_s: is missing"),
        ("time_s,a_um\ninf,2\n", "row 2, column time_s: inf is infinite"),
        ("time_s,T1_degC\n1,400\n2,400.5\n", "row 3, column T1_degC: 400.5 is outside -60..400"),
        ("time_s,T1_degC\n1,-60\n2,-61\n", "row 3, column T1_degC: -61 is outside -60..400 degC"),
        ("time_s,S1_um\n1,1e300\n", "row 2, column S1_um: 1e+300 is outside -1e+06..1e+06 um"),
        (b"time_s,a_um\n1,2\n2,\xff\n", "row 3: byte 0xff is not UTF-8"),
        (b"time_s,a_um\n1,2\n2,\x003\n", "row 3: holds a null character"),
    ],
)
def test_every_mistake_is_named_with_its_place(tmp_path, content, expected):
    path = tmp_path / "run.csv"
    path.write_bytes(content.encode() if isinstance(content, str) else content)
    assert refusal(read_run, path).startswith(f"{path}: {expected}")


ROWS = "time_s,speed_rpm,T1_degC,S1_um\n0,1000,20.5,0\n10,1000,20.7,1.25\n20,0,20.9,-0.3\n"


@pytest.mark.parametrize(
    "content",
    [
        ROWS.replace(",", ";").replace(".", ","),
        ROWS.replace("time_s", "Time [s]"),
        ROWS.replace("\n", ",\n"),
        ROWS.encode("utf-16"),
        ROWS.replace("speed_rpm", "speed_1/s"),
        ROWS.replace("T1_degC", "T1 oil degC"),
        ROWS.replace("\n20,", "\n10,"),
        ROWS + "30,0,21.0,0.1\n40,0,21.1,0.2\n50,0",
        ROWS.replace("20.7", "-999"),
    ],
)
def test_a_refusal_names_the_importer_only_if_that_reads_the_file(tmp_path, content):
    path = tmp_path / "run.csv"
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    assert refusal(read_run, path).endswith("; spindle-drift import reads this file")
    (run,) = import_files([path]).runs
    assert len(run.frame.columns) == 4
    assert run.of_unit("rpm") == ["speed_rpm"]
    path.write_text("time_s,a_um,a_um\n0,1,2\n1,2,3\n")
    assert refusal(read_run, path).endswith("'a_um' is also column 2")


NUMBERS = st.floats(-60, 400) | st.just(math.nan)


@given(times=st.lists(st.floats(-5e7, 5e7), min_size=1, max_size=20, unique=True), data=st.data())
def test_writing_and_reading_give_the_same_numbers(tmp_path, times, data):
    rows = len(times)
    column = st.lists(NUMBERS, min_size=rows, max_size=rows)
    frame = pd.DataFrame(
        {"time_s": sorted(times), "a,b_degC": data.draw(column), "S1_um": data.draw(column)}
    )
    path = write_run(frame, tmp_path / "run.csv")
    again = read_run(path)
    pd.testing.assert_frame_equal(again.frame, frame, check_exact=True)
    first = path.read_bytes()
    assert write_run(again, path).read_bytes() == first
    assert again.sha256 == Run("other", frame).sha256  # of the file, and of what would be written


CELL_FORM = re.compile(r"\s*([+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?|nan|NaN|NAN|)\s*", re.ASCII)


@given(
    row=st.integers(1, 3),
    column=st.integers(1, 3),
    cell=st.text(st.characters(blacklist_characters='\r\n,"\0', codec="utf-8"), max_size=8)
    | st.from_regex(r"[ +\-.0-9eE_infaNINF]{1,8}", fullmatch=True),
)
def test_a_mangled_cell_is_read_as_a_number_or_refused_by_name(tmp_path, row, column, cell):
    lines = [line.split(",") for line in GOOD.splitlines()]
    lines[row][column] = cell
    path = tmp_path / "run.csv"
    path.write_text("\n".join(",".join(line) for line in lines), encoding="utf-8", newline="")
    names = ["time_s", "speed_rpm", "T1_degC", "S1_um"]
    # What Python's own reading of the cell makes of it; none for what is not a number.
    expected = None
    if CELL_FORM.fullmatch(cell):
        expected = float(cell) if cell.strip(" \t\f\v") else math.nan
    low, high = (-60.0, 400.0) if column == 2 else (-1e6, 1e6)
    if expected is None or expected < low or expected > high:
        assert f"row {row + 1}, column {names[column]}: " in refusal(read_run, path)
    else:
        value = float(read_run(path).frame.iloc[row - 1, column])
        assert value == expected or (math.isnan(value) and math.isnan(expected))


@given(st.binary(max_size=60), st.integers(0, len(GOOD)), st.integers(0, len(GOOD)))
def test_a_mangled_file_is_read_or_refused_in_one_line(tmp_path, junk, start, end):
    content = GOOD.encode()
    path = tmp_path / "run.csv"
    path.write_bytes(content[: min(start, end)] + junk + content[max(start, end) :])
    try:
        frame = read_run(path).frame
    except BadInput as error:
        refused = str(error)
    else:
        refused = ""
        assert np.all(np.diff(frame["time_s"]) > 0)
        assert not np.isinf(frame.to_numpy()).any()
    assert "\n" not in refused


def test_a_run_keeps_its_own_copy_and_refuses_a_bad_frame():
    frame = pd.DataFrame({"time_s": [0.0, 1.0], "valid_1": [True, False]})
    run = Run("r", frame)
    frame.loc[0, "time_s"] = 5.0
    assert run.time_s.tolist() == [0.0, 1.0]
    assert run.frame["valid_1"].tolist() == [1.0, 0.0]
    assert "row 3, column time_s" in refusal(Run, "r", pd.DataFrame({"time_s": [0.0, 0.0]}))
    assert "not numeric" in refusal(Run, "r", pd.DataFrame({"time_s": [0.0], "a_um": ["x"]}))


def test_a_large_file_is_read_by_pandas_and_not_cell_by_cell(tmp_path, monkeypatch):
    rows = 30_000
    random = np.random.default_rng(0)
    columns = {f"T{i}_degC": random.normal(30.0, 1.0, rows).round(3) for i in range(29)}
    frame = pd.DataFrame({"time_s": np.arange(rows, dtype=float), **columns})
    path = write_run(frame, tmp_path / "large.csv")
    cells: list[str] = []
    plain = runs._number
    monkeypatch.setattr(runs, "_number", lambda *given: (cells.append(given[0]), plain(*given))[1])
    run = read_run(path)
    pd.testing.assert_frame_equal(run.frame, frame)
    assert cells == []
    # What pandas would take for something else is read the slow way.
    path.write_text("time_s,T1_degC\n0,1_0\n")
    assert "T1_degC" in refusal(read_run, path)
    assert cells


@pytest.mark.long
@pytest.mark.real_data
def test_every_measured_run_is_read_whole(lathe_runs, electric_spindle_run):
    for path in [*lathe_runs, electric_spindle_run]:
        run = read_run(path)
        assert len(run.frame) == path.read_text().count("\n") - 1
        assert run.temperatures
        assert run.displacements
        assert not run.frame.isna().any().any()
