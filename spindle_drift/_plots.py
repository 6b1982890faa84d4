"""Figures of the library's results."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np
import pandas as pd

from measurement.iso230 import summarise
from measurement.rig import AXES
from measurement.runs import Run
from scenarios.pages.charts import BEFORE, LINES, MANY, Chart, Line, Panel
from scenarios.views import before_and_after

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def plot_judged(frame: pd.DataFrame, name: str) -> Figure:
    """Return drift before and after compensation, one panel per axis."""
    panels = before_and_after([("Compensated", frame)], frame)
    return _drawn(Chart("judged", f"Drift before and after compensation: {name}", "", panels))


def plot_frames(frames: Mapping[str, pd.DataFrame]) -> Figure:
    """Return the remaining error in each variant of a scenario, one panel per axis."""
    panels = []
    for axis in AXES:
        lines = [
            Line(
                name,
                frame["time_s"].to_numpy(float),
                frame[f"error_{axis}_um"].to_numpy(float),
                (*LINES, *MANY)[at % (len(LINES) + len(MANY))],
            )
            for at, (name, frame) in enumerate(frames.items())
            if f"error_{axis}_um" in frame
        ]
        if lines:
            panels.append(Panel(f"{axis} [µm]", tuple(lines)))
    return _drawn(Chart("scenario", "Remaining error", "", tuple(panels)))


def plot_run(run: Run) -> Figure:
    """Return a run's temperatures, displacements and speed."""
    from matplotlib import pyplot

    from scenarios.pages.run_figure import draw_overview

    return draw_overview(run, summarise(run), figure=pyplot.figure())


def plot_bars(table: pd.DataFrame, title: str, label: str) -> Figure:
    """Return horizontal bars: a group per row, a bar per column."""
    from matplotlib import pyplot

    rows = table[::-1]
    figure = pyplot.figure(figsize=(9.0, 1.2 + 0.3 * len(rows) * len(rows.columns) ** 0.5))
    ax = figure.add_subplot()
    places = np.arange(len(rows))
    height = 0.8 / len(rows.columns)
    for at, column in enumerate(rows.columns):
        shift = 0.4 - (at + 0.5) * height
        colour = (BEFORE, *LINES)[at % (1 + len(LINES))]
        ax.barh(places + shift, rows[column].to_numpy(float), height, color=colour, label=column)
    ax.set_yticks(places, [str(name) for name in rows.index])
    ax.set_xlabel(label)
    ax.set_title(title, loc="left", fontsize=12)
    ax.spines[["top", "right"]].set_visible(False)
    ax.grid(True, axis="x", color="#e3e6ea", linewidth=0.8)
    ax.set_axisbelow(True)
    ax.legend(frameon=False, fontsize=9)
    figure.set_layout_engine("constrained")
    return figure


def _drawn(chart: Chart) -> Figure:
    """Return a pyplot figure, which a notebook or ``pyplot.show()`` displays."""
    from matplotlib import pyplot

    from scenarios.pages.figures import draw_on

    return draw_on(chart, pyplot.figure())
