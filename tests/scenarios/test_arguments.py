"""Options made from a function's signature and docstring."""

import argparse
from dataclasses import dataclass

import pytest

from scenarios.arguments import add_parameters, parameters_of


@dataclass(frozen=True)
class Order:
    """What is ordered.

    Attributes
    ----------
    cake : str
        Which one.
    rest_s : float, optional
        How long it *rests* [s].
    size : {"half-pound", "pound"}, optional
        How much.
    signs : tuple of str
        What stands on it, such as 'T*=Tea'.
    """

    cake: str
    rest_s: float | None = None
    size: str | None = None
    signs: tuple[str, ...] = ()


def test_the_fields_of_a_dataclass_are_options_and_one_without_a_default_must_be_given(capsys):
    made = argparse.ArgumentParser()
    add_parameters(made, Order, "cake", "rest_s", "size", signs={"flag": ("-s", "--sign")})
    given = ["plum", "--rest", "90", "--size", "half-pound", "-s", "a=b", "--sign", "c"]
    assert Order(**parameters_of(made.parse_args(given), Order)) == Order(
        "plum", 90.0, "half-pound", ["a=b", "c"]
    )
    assert parameters_of(made.parse_args(["plum"]), Order)["signs"] == []
    with pytest.raises(SystemExit):
        made.parse_args([])
    assert "required: CAKE" in capsys.readouterr().err
    text = " ".join(made.format_help().split())
    assert "--rest SECONDS how long it rests --size {half-pound,pound} how much" in text
    assert "such as 'T*=Tea'; may be repeated" in text
