"""Thinning of curves, and the table's figures and titles."""

from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from matplotlib.figure import Figure

from scenarios.pages.charts import Chart, Line, Panel, kept, kept_steps
from scenarios.pages.figures import draw_on
from scenarios.table import as_list, as_text, group_of, overall
from scenarios.views import group_title, minute_means

SERIES = arrays(
    np.float64, st.integers(1, 400), elements=st.one_of(st.floats(-1e6, 1e6), st.just(np.nan))
)


@given(values=SERIES, most=st.integers(4, 60))
def test_thinning_loses_no_extreme_and_no_gap(values, most):
    found = kept(values, most)
    assert np.all(np.diff(found) > 0)
    assert found[0] == 0
    assert found[-1] == len(values) - 1
    assert len(found) <= max(most // 2 * 3 + 2, most)
    valid = ~np.isnan(values)
    if valid.any():
        assert np.nanmax(values[found]) == np.nanmax(values)
        assert np.nanmin(values[found]) == np.nanmin(values)
    assert np.isnan(values[found]).any() == (not valid.all())


def test_a_legend_stays_within_its_figure():
    rise = np.arange(2.0)
    lines = tuple(Line(f"A variant of a scenario {i}", rise, rise, "k") for i in range(5))
    figure = draw_on(Chart("drift", "Drift", "", (Panel("X", lines),)), Figure())
    (legend,) = figure.legends
    assert legend.get_window_extent().width <= figure.bbox.width


@given(st.lists(st.tuples(st.integers(0, 3), st.integers(1, 50)), min_size=1, max_size=30))
def test_thinning_of_steps_can_be_drawn_back(levels):
    values = np.concatenate([np.full(count, float(level)) for level, count in levels])
    found = kept_steps(values)
    held = values[found][np.searchsorted(found, np.arange(len(values)), side="right") - 1]
    assert np.array_equal(held, values)
    assert len(found) <= len(levels) + 1


def test_minute_means_leave_gaps_and_make_no_last_minute_of_one_sample():
    time = np.arange(181.0)
    values = np.where((time >= 60) & (time < 120), np.nan, time)
    moments, means = minute_means(time, values)
    assert moments.tolist() == [30.0, 90.0, 150.0]
    assert means.tolist() == pytest.approx([29.5, np.nan, 150.0], nan_ok=True)


@pytest.mark.parametrize("lengths", [[100.0, 220.0, 60.0, 180.0], np.linspace(220.0, 60.0, 500)])
def test_a_title_names_the_range_of_tools_however_many_there_are(lengths):
    group = [SimpleNamespace(frame=pd.DataFrame({"tool_length_mm": lengths}))]
    assert group_title(group) == "Tools of 60 to 220 mm"


def frame(before: list[float], after: list[float]) -> pd.DataFrame:
    return pd.DataFrame({"drift_X_um": before, "error_X_um": after})


def test_a_group_has_the_line_without_compensation_on_top():
    group = group_of("Tool", [("a", "A", frame([10.0, -20.0], [1.0, -3.0]))])
    reference, row = group.rows
    assert reference.is_reference
    assert reference.axes["X"].after_max_um == 20.0
    assert reference.axes["X"].after_mean_um == 15.0
    assert row.axes["X"].after_max_um == 3.0
    assert row.axes["X"].improvement_percent == pytest.approx(100 * (1 - 2 / 15))


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
