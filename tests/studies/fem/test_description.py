"""The description file is refused in one line wherever it is wrong."""

import tomllib
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

import studies.finite_elements as package
from measurement.errors import BadInput, checked
from studies.finite_elements import Description, FiniteElementSpindle, read_description
from tests.mangling import JUNK, mangled, places
from tests.refusing import refusal
from tests.studies.fem.conftest import bar_table

SHIPPED = tomllib.loads((Path(package.__file__).parent / "jig_borer.toml").read_text())


@pytest.mark.parametrize(
    ("text", "problem"),
    [
        ("format = ", "is not TOML"),
        ("format = 2", "format: 2 is not allowed"),
        ("format = 1", "name: is missing"),
        ("\udcff".encode("utf-8", "surrogateescape").decode("latin-1"), "is not TOML"),
    ],
)
def test_a_file_that_is_none_is_refused(tmp_path, text, problem):
    path = tmp_path / "bad.toml"
    path.write_text(text)
    assert problem in refusal(read_description, path)
    assert "no such file" in refusal(read_description, tmp_path / "nowhere.toml")


@pytest.mark.parametrize(
    ("changes", "problem"),
    [
        ({"parts": [{"name": "bar", "material": "wood", "r": [1, 2], "z": [0, 1]}]}, "wood"),
        ({"motors": [{"name": "m", "watts_per_1000rpm": 1, "shares": {"x": 1}}]}, "'x' is not a"),
        ({"motors": [{"name": "m", "watts_per_1000rpm": 1, "shares": {"bar": 0}}]}, "all be 0"),
        ({"motors": []}, "nothing would warm"),
        ({"surfaces": []}, "get rid of its heat"),
        ({"mount": {"z": 0.0, "r": [1.0, "a"]}}, "mount"),
    ],
)
def test_what_does_not_fit_together_is_refused(changes, problem):
    assert problem in refusal(checked, Description, bar_table(**changes), "bar.toml")


@pytest.mark.parametrize(
    ("changes", "problem"),
    [
        ({"element_mm": 0.21, "nose": {"z": 9e3, "r": [20, 40]}}, "elements; 40000 are allowed"),
        ({"mount": {"z": 55.0, "r": [100.0, 120.0]}}, "mount: does not lie on a part"),
        ({"jackets": [{"name": "j", "r": [1, 2], "z": [0, 1], "conductance": 9}]}, "j: covers no"),
    ],
)
def test_what_the_mesh_cannot_hold_is_refused(changes, problem):
    if "element_mm" in changes:
        part = {"name": "bar", "material": "steel", "r": [20, 40], "z": [0, 9e3]}
        changes = changes | {"parts": [part]}
    description = Description.model_validate(bar_table(**changes))
    with pytest.raises(BadInput, match=problem):
        FiniteElementSpindle(description).growth_row  # noqa: B018 - built when asked for


@given(where=st.sampled_from(list(places(SHIPPED))), value=JUNK)
def test_any_mangled_field_is_refused_in_one_line_or_accepted(where, value):
    table = mangled(SHIPPED, where, value)
    problem = ""
    try:
        checked(Description, table, "mangled.toml")
    except BadInput as refused:
        problem = str(refused)
    assert "\n" not in problem
