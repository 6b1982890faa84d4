"""The compensator file is checked in every field."""

import copy
import json
from collections.abc import Callable, Iterator
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fmu_compensator.runtime.modelfile import ModelFileError, load_model, model_text, parse_model
from tests.fmu_compensator.gaussians import knows_nothing, learnt
from tests.mangling import mangled, places
from tests.refusing import refusal

FREE = ("provenance.options", "provenance.figures")  # any table of JSON values may stand there
FIGURES = {
    "training": {"X": {"model": 1.0, "no_model": 2.0}},
    "conditions": [[20.0, 22.0], [0.5, 6.0], None, [2.0, 8.0]],
    "unseen": {
        "like": {"X": {"model": 1.0, "no_model": 2.0, "expected": 1.0, "inside": 0.9}},
        "like_behind": 3,
        "by_run": [{"run": "a", "miss": [0.5, None, 0.5], "new": 0.0}],
        "promised": {"X": {"model": 1.0, "no_model": 2.0}},
    },
}
"""As `fit` writes them."""


def fields(table: Any) -> Iterator[tuple[Any, ...]]:
    """Yield the path of every field, what stands in a free table left out."""
    for path in places(table):
        if ".".join(map(str, path[:2])) not in FREE or len(path) == 2:
            yield path


def assert_refused(table: Any) -> ModelFileError:
    with pytest.raises(ModelFileError) as caught:
        parse_model(json.dumps(table), "file.json")
    text = str(caught.value)
    assert "\n" not in text
    assert text.startswith("file.json: ")
    return caught.value


def refusal_of(read: Callable[[], object]) -> str:
    """Return what a refusal says; empty when there is none. Any other exception goes through."""
    try:
        read()
    except ModelFileError as error:
        return str(error)
    return ""


def test_a_written_file_is_read_back_the_same(five_point_table, tmp_path):
    path = tmp_path / "c.json"
    path.write_text(model_text(five_point_table), encoding="utf-8")
    model = load_model(path)
    assert model.table == five_point_table
    assert model.chosen == (3, 0)
    assert [one.name for one in model.sensors] == ["T1", "T2", "T3", "T4"]
    assert model.limits.tool_length_mm == (0.0, 200.0)
    assert model.limits.share == 1.0  # it may be left out


def test_every_field_is_needed(five_point_table, direct_table):
    for table in (five_point_table, direct_table, learnt(five_point_table)):
        tried = 0
        for path in fields(table):
            # Notes, runs, directions seen and sensors not used by the model may be any number.
            any_number = {("provenance", "notes"), ("provenance", "runs"), ("gaussian", "seen")}
            if path[:2] in any_number and len(path) == 3:
                continue
            if path in {("sensors", 1), ("sensors", 2)}:
                continue
            assert_refused(mangled(table, path))
            tried += 1
        assert tried > 50


@pytest.mark.parametrize(
    "path",
    [
        ("training", "X", "model"),
        ("unseen", "like", "X", "inside"),
        ("unseen", "like_behind"),
        ("unseen", "promised", "X"),
        ("unseen", "by_run", 0, "miss"),
        ("unseen", "by_run", 0, "miss", 2),
        ("conditions", 0),
        ("conditions",),
    ],
)
def test_figures_that_cannot_be_continued_from_are_refused(five_point_table, path):
    five_point_table["provenance"]["figures"] = copy.deepcopy(FIGURES)
    assert parse_model(json.dumps(five_point_table), "file.json")
    *above, last = ("provenance", "figures", *path)
    table = five_point_table
    for key in above:
        table = table[key]
    table[last] = "x"
    place = ".".join(map(str, ("provenance", "figures", *path)))
    assert place.startswith(assert_refused(five_point_table).place)


def may_hold(field: str, junk: Any) -> bool:
    """Return whether the junk happens to be allowed in the field."""
    if junk is None:
        return field.endswith(("created", "spare", "stale_after_s"))
    if junk == []:
        return field in {"provenance.runs", "provenance.notes", "gaussian.seen", "gaussian.lags_s"}
    if junk == {"a": 1}:
        return field in FREE
    return isinstance(junk, str) and field.startswith("provenance.notes.")


@pytest.mark.parametrize(
    "junk", [None, True, "\x00", [], [[]], {"a": 1}, 1e400, -1e300, 10**400, "x" * 1000]
)
def test_every_field_refuses_what_it_cannot_hold(five_point_table, direct_table, junk):
    for table in (five_point_table, direct_table, learnt(five_point_table)):
        for path in fields(table):
            asked = table is not five_point_table and table[path[0]] == five_point_table[path[0]]
            if asked or may_hold(".".join(map(str, path)), junk):
                continue
            damaged = mangled(table, path, junk)
            # Infinity is no JSON: the whole file is refused. A renamed sensor shows in the choice.
            assert assert_refused(damaged).place.split(".")[0] in {path[0], "", "chosen"}


@given(data=st.data())
def test_any_damaged_bytes_give_a_model_or_one_line(five_point_table, tmp_path, data):
    content = bytearray(json.dumps(five_point_table).encode())
    for _ in range(data.draw(st.integers(1, 4))):
        at = data.draw(st.integers(0, len(content) - 1))
        content[at : at + data.draw(st.integers(0, 3))] = data.draw(st.binary(max_size=3))
    path = tmp_path / "damaged.json"
    path.write_bytes(bytes(content))
    told = refusal_of(lambda: load_model(path))
    assert "\n" not in told
    assert not told or told.startswith(f"{path}: ")


@pytest.mark.parametrize(
    ("field", "value", "place", "told"),
    [
        ("format", 5, "format", "newer version"),
        ("format", 0, "format", "whole number"),
        ("kind", "other", "kind", "spindle-drift compensator"),
        ("extra", 1, "'extra'", "not a known field"),
        ("created", "31.1.2026", "created", "date"),
        ("chosen", ["T9"], "chosen.0", "one of the sensors"),
        ("chosen", ["T1", "T1"], "chosen.1", "different"),
        ("chosen", [], "chosen", "at least 1 names"),
        ("chosen", ["T1"], "error_model.coefficients.0", "a list of 1 numbers"),
        ("input_form", "delta", "input_form", "rise, absolute"),
        ("name", "no good", "name", "a name"),
        ("gaussian", knows_nothing(5, inputs=3), "gaussian.weights.0", ""),
        ("gaussian", knows_nothing(2), "gaussian.noise", ""),
        ("limits.share", -0.1, "limits.share", ""),
        ("limits.share", 1.1, "limits.share", ""),
        ("limits.share", None, "limits.share", ""),
    ],
)
def test_a_refusal_says_where_and_what_is_allowed(five_point_table, field, value, place, told):
    error = assert_refused(mangled(five_point_table, field, value))
    assert error.place == place
    assert told in str(error)


def test_a_file_of_a_version_before_says_how_to_go_on(five_point_table):
    fields = {"guard": {}, "correction": None, "interval": None, "training": {}}
    error = assert_refused(five_point_table | fields | {"format": 2})
    again = "fit it again from its runs: spindle-drift fit RUN... -o FILE"
    assert str(error) == f"file.json: format: 2 is of an older version; {again}"


def test_two_columns_for_one_axis_are_refused(direct_table):
    direct_table["geometry"]["axes"]["disp_z"]["axis"] = "X"
    assert assert_refused(direct_table).place == "geometry.axes.disp_z.axis"


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("", "not JSON"),
        ("[]", "must be a table"),
        ("{", "not JSON"),
        ('{"a": NaN}', "not a number"),
        ('{"a": 1, "a": 2}', "stands twice"),
        ('{"a": ' + "9" * 5000 + "}", "not allowed"),
        ("[" * 100_000, "nested too deeply"),
    ],
)
def test_what_is_no_table_is_refused(text, told):
    assert told in refusal(parse_model, text, "file.json")


def test_a_file_that_cannot_be_read_is_refused(tmp_path):
    for path in (tmp_path / "none.json", tmp_path):
        assert "cannot be read" in refusal(load_model, path)
    path = tmp_path / "binary.json"
    path.write_bytes(b"\xff\xfe\x00")
    assert "UTF-8" in refusal(load_model, path)


def test_nothing_is_written_that_could_not_be_read(five_point_table):
    five_point_table["limits"]["hold_s"] = float("nan")
    assert "limits.hold_s: nan is not allowed" in refusal(model_text, five_point_table)
    five_point_table["limits"]["hold_s"] = -1.0
    assert "limits.hold_s" in refusal(model_text, five_point_table)
