"""Figures of merit against hand-made numbers and other libraries' definitions."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from measurement.figures import figures_of_merit, improvement


def test_every_figure_of_a_small_example():
    # e = 0, 1, -2, 1; y = 0, 10, 20, 50; mean y = 20; SST = 400 + 100 + 0 + 900 = 1400
    figures = figures_of_merit([0.0, 10.0, 20.0, 50.0], [0.0, 9.0, 22.0, 49.0])
    assert figures == {
        "max_abs": 2.0,
        "min_abs": 0.0,
        "mean_abs": 1.0,
        "rmse": math.sqrt(6 / 4),
        "r2": pytest.approx(1 - 6 / 1400, rel=1e-15),
        "sse": 6.0,
        "mae": 1.0,
        "mape": pytest.approx(100 * (1 / 10 + 2 / 20 + 1 / 50) / 3, rel=1e-15),
        "eta": 1 - 4 / 80,
        "mape_left_out": 1.0,
        "samples": 4.0,
        "missing": 0.0,
    }


VALUES = st.floats(-100, 100).map(lambda v: round(v, 3))


@given(st.lists(st.tuples(VALUES, VALUES), min_size=3, max_size=30), st.integers(1, 5))
def test_missing_pairs_change_nothing_but_their_count(pairs, missing):
    y, yhat = map(list, zip(*pairs, strict=True))
    plain = figures_of_merit(y, yhat)
    holed = figures_of_merit([*y, *[math.nan] * missing, 1.0], [*yhat, *[2.0] * missing, math.nan])
    assert holed.pop("missing") == missing + 1
    assert plain.pop("missing") == 0
    assert holed == pytest.approx(plain, nan_ok=True)


def test_what_the_data_do_not_define_is_nan():
    constant = figures_of_merit([0.1, 0.1, 0.1], [0.2, 0.2, 0.2])
    assert math.isnan(constant["r2"])
    zero = figures_of_merit([0.0, 0.0], [1.0, 1.0])
    assert math.isnan(zero["eta"])
    assert math.isnan(zero["mape"])
    assert zero["mape_left_out"] == 2.0
    nothing = figures_of_merit([math.nan], [1.0])
    assert math.isnan(nothing["rmse"])
    assert (nothing["samples"], nothing["missing"]) == (0.0, 1.0)


def test_unlike_shapes_and_infinite_values_are_refused():
    with pytest.raises(ValueError, match=r"shape \(2,\) and predicted \(1,\)"):
        figures_of_merit([1.0, 2.0], [1.0])
    with pytest.raises(ValueError, match="infinite"):
        figures_of_merit([1.0, math.inf], [1.0, 2.0])


@pytest.mark.parametrize(
    ("before", "after", "percent"), [(24.7, 3.6, 85), (24.6, 2.8, 89), (14.5, 3.3, 77)]
)
def test_improvement_reproduces_the_studies(before, after, percent):
    assert round(100 * improvement(before, after)) == percent


def test_mape_leaves_out_what_is_near_zero_and_says_how_many():
    y, yhat = [0.5, 1.0, 100.0], [1.5, 2.0, 101.0]
    found = figures_of_merit(y, yhat)  # near zero: below 1 % of 100
    assert found["mape_left_out"] == 1.0
    assert found["mape"] == pytest.approx((100.0 + 1.0) / 2)


def test_improvement_may_be_negative_or_undefined():
    assert improvement(1.0, 3.0) == -2.0
    assert math.isnan(improvement(0.0, 1.0))
