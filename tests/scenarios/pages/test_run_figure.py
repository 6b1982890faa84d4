"""The figure of a run."""

import math

import numpy as np
import pandas as pd
import pytest
from matplotlib.figure import Figure

from measurement.iso230 import summarise
from measurement.rig import FivePointRig, Rig
from measurement.runs import Run
from scenarios.pages.run_figure import draw_overview

RIG = FivePointRig(spacing_mm=100.0, near_to_gauge_mm=30.0)
TIME = 60.0 * np.arange(120)
FULL = pd.DataFrame(
    {
        "time_s": TIME,
        "speed_rpm": 1000.0,
        "feed_mm_min": 10.0,
        "T1_degC": 20.0 + TIME / 1000,
        "T2_degC": 20.0 + TIME / 2000,
        **{f"S{i}_um": i * TIME / 1000 for i in range(1, 6)},
    }
)


def draw(frame: pd.DataFrame, rig: Rig | None = None) -> Figure:
    run = Run("r", frame)
    return draw_overview(run, summarise(run, rig), rig)


def labels(figure: Figure) -> list[str]:
    return [axes.get_ylabel() for axes in figure.axes if axes.get_ylabel()]


@pytest.mark.parametrize(
    ("columns", "expected"),
    [
        (list(FULL), ["speed [r/min]", "temperature [°C]", "displacement [µm]", "tilt [µrad]"]),
        (["time_s", "T1_degC"], ["temperature [°C]"]),
        (["time_s", "S1_um", "feed_mm_min"], ["feed [mm/min]", "displacement [µm]"]),
        (["time_s"], []),
    ],
)
def test_there_is_a_panel_per_kind_of_signal_that_the_run_has(columns, expected):
    figure = draw(FULL[columns], RIG)
    found = labels(figure)
    assert [label for label in found if label in expected] == expected
    assert set(found) - set(expected) <= {"feed [mm/min]"}
    assert figure.axes[0].get_figure() is figure


def test_a_line_is_not_drawn_across_a_gap():
    holed = FULL["S1_um"].to_numpy().copy()
    holed[40:60] = math.nan
    figure = draw(FULL.assign(S1_um=holed)[["time_s", "S1_um"]])
    line = next(
        line for axes in figure.axes for line in axes.get_lines() if line.get_label() == "S1"
    )
    drawn = np.asarray(line.get_ydata(), dtype=float)
    assert np.isnan(drawn).sum() == 1
    assert np.count_nonzero(~np.isnan(drawn)) == 100


def test_frozen_stretches_are_shaded_once():
    frame = FULL.assign(S1_um=0.0, S2_um=0.0)
    figure = draw(frame)
    shaded = [
        patch.get_label() for axes in figure.axes for patch in axes.patches if patch.get_alpha()
    ]
    assert shaded == ["frozen or saturated"]
