"""What is said of a file's field that is misspelt or of the wrong form."""

from typing import Annotated, Literal

import pytest
from pydantic import BaseModel, ConfigDict, Field

from measurement.errors import BadInput, checked, matching


class Carrier(BaseModel):
    model_config = ConfigDict(extra="forbid")
    mass: float
    surface: float


def test_a_misspelt_field_is_named_beside_the_one_that_is_missing():
    with pytest.raises(
        BadInput, match=r"^page: surface: is missing, and surfase is not a known field$"
    ):
        checked(Carrier, {"mass": 3.0, "surfase": 1.2}, "page")
    with pytest.raises(BadInput, match=r"^page: surface: is missing$"):
        checked(Carrier, {"mass": 3.0}, "page")


class Frame(BaseModel):
    late_ms: Annotated[float, Field(gt=0.0)] | Literal["never"] = "never"


class Map(BaseModel):
    frames: dict[str, Frame]


def test_a_place_is_made_of_the_file_s_own_keys():
    with pytest.raises(BadInput, match=r"^map: frames\.TEMP\.late_ms: 0 is not allowed"):
        checked(Map, {"frames": {"TEMP": {"late_ms": 0}}}, "map")


@pytest.mark.parametrize(
    ("place", "said"),
    [
        ("shaft.stretches.0.outer", "shaft.stretches, item 1, outer"),
        ("variants.1.set (b): faults.0", "variants, item 2, set (b): faults, item 1"),
        ("rates.0.11", "rates, item 1, item 12"),
        ("row 2, column T1.2_degC", "row 2, column T1.2_degC"),
        ("links.shaft-housing.gap", "links.shaft-housing.gap"),
    ],
)
def test_items_of_lists_are_counted_from_one(place, said):
    assert str(BadInput("page", place, "no")) == f"page: {said}: no"
    assert str(BadInput("--vary", place, "no")) == f"--vary: {place}: no"


class Part(BaseModel):
    name: Annotated[str, matching(r"[a-z]+", "small letters")]


@pytest.mark.parametrize("text", ["", "a b", "shaft\n"])
def test_a_name_of_the_wrong_form_is_refused_in_words(text):
    assert checked(Part, {"name": "shaft"}, "page").name == "shaft"
    with pytest.raises(
        BadInput, match=r"^page: name: .* is not allowed: it must be small letters$"
    ):
        checked(Part, {"name": text}, "page")
