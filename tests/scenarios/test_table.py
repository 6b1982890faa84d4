"""The headline table."""

import math

import pandas as pd
import pytest

from scenarios.table import as_list, as_text, group_of, overall


def test_a_sample_counts_only_with_drift_and_error():
    frame = pd.DataFrame(
        {
            "time_s": [0.0, 1.0],
            "drift_Z_um": [-20.0, -30.0],
            "drift_X_um": [10.0, math.nan],
            "error_X_um": [2.0, 9.0],
            "error_Z_um": [5.0, -5.0],
            "drift_Y_um": [math.nan, math.nan],
            "error_Y_um": [1.0, 1.0],
        }
    )
    reference, row = group_of("", [("run", "Compensated", frame)]).rows
    assert reference.is_reference
    assert list(row.axes) == ["X", "Y", "Z"]
    assert row.axes["X"].to_dict() == {
        "before_max_um": 10.0,
        "before_mean_um": 10.0,
        "after_max_um": 2.0,
        "after_mean_um": 2.0,
        "improvement_percent": 80.0,
        "samples": 1,
    }
    z = row.axes["Z"]
    assert (z.before_max_um, z.before_mean_um, z.after_max_um) == (30.0, 25.0, 5.0)
    assert z.improvement_percent == 80.0
    assert set(row.axes["Y"].to_dict().values()) == {None, 0}
    assert reference.axes["Z"].improvement_percent == 0.0


def frame(before: list[float], after: list[float]) -> pd.DataFrame:
    return pd.DataFrame({"drift_X_um": before, "error_X_um": after})


def test_all_runs_together_weigh_every_sample_the_same():
    groups = [
        group_of("one", [("1", "C", frame([10.0] * 3, [1.0] * 3))]),
        group_of("two", [("2", "C", frame([30.0], [5.0]))]),
    ]
    row = overall(groups, "all").rows[1].axes["X"]
    assert (row.before_mean_um, row.after_mean_um) == (15.0, 2.0)
    assert (row.before_max_um, row.after_max_um) == (30.0, 5.0)
    assert row.improvement_percent == pytest.approx(100 * (1 - 2 / 15))


def test_the_text_table_shows_the_figures_under_their_axes():
    text = as_text([group_of("Tool", [("a", "A", frame([10.0, -20.0], [1.0, -3.0]))])])
    lines = text.splitlines()
    assert "X [um]" in lines[0]
    assert lines[3].split() == ["No", "compensation", "20.0", "15.0"]
    assert lines[4].split() == ["A", "3.0", "2.0", "87", "%"]


def test_a_figure_that_is_not_defined_is_null_in_json():
    group = group_of("Tool", [("a", "A", frame([0.0], [0.0]))])
    assert as_list([group])[0]["rows"][1]["axes"]["X"]["improvement_percent"] is None
    assert as_text([group]).splitlines()[-1].split() == ["A", "0.0", "0.0", "-"]
