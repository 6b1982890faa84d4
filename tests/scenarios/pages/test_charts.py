"""Thinning of curves, and the titles of figures."""

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
from scenarios.views import before_and_after, group_title, minute_means

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


def test_rare_measurements_are_joined_and_only_a_long_gap_is_not():
    time = np.arange(0.0, 3600.0, 10.0)
    drift = pd.DataFrame({"time_s": time, "drift_Z_um": np.nan})
    probed = np.flatnonzero((np.arange(len(time)) % 10 == 0) & ((time < 1000.0) | (time > 3000.0)))
    drift.loc[probed, "drift_Z_um"] = 1.0
    after = drift[["time_s"]].assign(error_Z_um=drift["drift_Z_um"], dZ_uncertainty_um=2.0)
    (panel,) = before_and_after([("with", after), ("other", after)], drift)
    before, error, *interval = panel.lines[:4]
    for line in (before, error):
        np.testing.assert_array_equal(line.time_s[np.isfinite(line.values)], time[probed])
        assert np.isnan(line.values).sum() == 1
    assert {line.label for line in interval} == {"interval of the remaining error, with"}
