"""Figures of merit against hand-made numbers and other libraries' definitions."""

import math

import pandas as pd
import pytest
from hypothesis import given
from hypothesis import strategies as st

from measurement.figures import compensation_table, figures_of_merit, improvement


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


def test_improvement_of_arrays():
    assert improvement([10.0, -10.0], [1.0, -3.0]) == pytest.approx(0.8)
    assert improvement([10.0, math.nan, 10.0], [1.0, 50.0, math.nan]) == pytest.approx(0.9)
    assert improvement([10.0, math.nan], [1.0, 2.0, 3.0]) == pytest.approx(0.8)
    assert improvement([1.0], [3.0]) == -2.0
    assert math.isnan(improvement([0.0, 0.0], [0.0, 1.0]))


def tables() -> tuple[pd.DataFrame, pd.DataFrame]:
    before = pd.DataFrame(
        {"time_s": [0.0, 1.0], "drift_Z_um": [-20.0, -30.0], "drift_X_um": [10.0, math.nan]}
    )
    after = pd.DataFrame({"error_X_um": [2.0, 9.0], "error_Z_um": [5.0, -5.0]})
    return before, after


def test_a_compensation_table_by_axis():
    x, z = compensation_table(*tables())
    assert x.to_dict() == {
        "axis": "X",
        "before_max_um": 10.0,
        "before_mean_um": 10.0,
        "after_max_um": 2.0,
        "after_mean_um": 2.0,
        "improvement_percent": 80.0,
        "samples": 1,
    }
    assert (z.axis, z.before_max_um, z.before_mean_um, z.after_max_um) == ("Z", 30.0, 25.0, 5.0)
    assert z.improvement_percent == 80.0


@pytest.mark.parametrize(
    ("change", "expected"),
    [
        (lambda b, a: (b, a.iloc[:1]), "before has 2 rows and after 1"),
        (lambda b, a: (b.drop(columns="drift_X_um"), a), r"axes \['Z'\] and after \['X', 'Z'\]"),
        (lambda b, a: (b, a.assign(X=1.0)), "two columns for axis X"),
    ],
)
def test_tables_that_do_not_match_are_refused(change, expected):
    with pytest.raises(ValueError, match=expected):
        compensation_table(*change(*tables()))


def test_mape_leaves_out_what_is_near_zero_and_says_how_many():
    y, yhat = [0.5, 1.0, 100.0], [1.5, 2.0, 101.0]
    found = figures_of_merit(y, yhat)  # near zero: below 1 % of 100
    assert found["mape_left_out"] == 1.0
    assert found["mape"] == pytest.approx((100.0 + 1.0) / 2)
