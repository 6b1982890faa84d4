"""What ``--vary`` says: grids, ranges, distributions, and what it refuses."""

import math

import numpy as np
import pytest

from measurement.errors import BadInput
from scenarios.sweep.variation import variation


@pytest.mark.parametrize(
    ("text", "values"),
    [
        ("tool_length=100,200, 300", (100, 200, 300)),
        ("a=-1.5", (-1.5,)),
        ("a=0.1..0.3:3", (0.1, 0.2, 0.3)),
        ("a=-1e1..10:5", (-10.0, -5.0, 0.0, 5.0, 10.0)),
        ("plant.noise=true,false", (True, False)),
        ("plant.fmu=one.toml,two.toml", ("one.toml", "two.toml")),
        ('a=500,{ kind = "constant" }', (500, {"kind": "constant"})),
    ],
)
def test_a_grid(text, values):
    found = variation(text)
    assert found.values == values
    assert not found.is_drawn
    assert not found.relative


def test_an_x_makes_factors_of_the_values():
    found = variation("gap=x0.9,1.1")
    assert (found.name, found.relative, found.label) == ("gap", True, "gap_factor")
    assert found.values == (0.9, 1.1)
    assert variation("gap=x0.9..1.1").kind == "uniform"
    assert variation("plant.fmu=xl.toml").values == ("xl.toml",)


def draws(text: str, low: float = -math.inf, high: float = math.inf) -> np.ndarray:
    found = variation(text)
    return np.array([found.drawn(7, repeat, low, high) for repeat in range(2000)])


def test_a_uniform_draw_fills_its_range_evenly():
    values = draws("a=10..20")
    assert 10.0 <= values.min() < 10.1
    assert 19.9 < values.max() <= 20.0
    assert values.mean() == pytest.approx(15.0, abs=0.2)


def test_a_logarithmic_draw_has_as_much_in_every_decade():
    values = draws("a=1..1000:log")
    assert np.histogram(values, [1.0, 10.0, 100.0, 1000.0])[0] == pytest.approx(667, abs=70)


def test_a_normal_draw_has_its_mean_and_deviation_and_keeps_to_the_limits():
    values = draws("a=100+-5")
    assert (values.mean(), values.std()) == pytest.approx((100.0, 5.0), abs=0.4)
    cut = draws("a=100+-5", 99.0, 200.0)
    assert cut.min() >= 99.0
    assert cut.mean() > 101.0
    far = draws("a=100+-5", 0.0, 1.0)
    assert far.min() >= 0.0
    assert far.max() <= 1.0


def test_a_draw_belongs_to_its_seed_name_and_repeat_alone():
    one, other = variation("a=0..1"), variation("b=0..1")
    value = one.drawn(1, 2, -math.inf, math.inf)
    assert value == one.drawn(1, 2, -math.inf, math.inf)
    others = {other.drawn(1, 2, 0, 1), one.drawn(2, 2, 0, 1), one.drawn(1, 3, 0, 1)}
    assert len(others | {value}) == 4


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("speed", "is not of the form NAME=VALUES"),
        ("=1,2", "is not of the form NAME=VALUES"),
        ("speed=", "speed: there is no value"),
        ("speed=,", "speed: there is no value"),
        ("speed=1,,2", "speed: '' is not allowed"),
        ("speed=1,2,1", "speed: 1 is there twice"),
        ("speed=1,nan", "speed: nan is not allowed"),
        ("speed=5..1", "speed: 5..1 is no range"),
        ("speed=1..1", "speed: 1..1 is no range"),
        ("speed=0..1:log", "must lie above 0"),
        ("speed=0..1:1", "1 values are not allowed: 2 to 10000"),
        ("speed=5+-0", "deviation of 0 is not above 0"),
        ("speed=x1,fast", "speed: '1' is not allowed"),
        ("speed=x1,true", "speed: True is not allowed"),
        ("speed=1e999..2e999", "is no range"),
    ],
)
def test_what_says_nothing_is_refused(text, message):
    with pytest.raises(BadInput, match=r"^--vary: ") as refused:
        variation(text)
    assert message in str(refused.value)
