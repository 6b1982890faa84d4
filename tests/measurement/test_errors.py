"""What is said of a file's field that is misspelt."""

import pytest
from pydantic import BaseModel, ConfigDict

from measurement.errors import BadInput, checked


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
