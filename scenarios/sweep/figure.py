"""The figure of a sweep: percentiles over time, and the cases themselves."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from scenarios.pages.charts import BEFORE, LINES
from scenarios.pages.figures import plain, saved
from scenarios.sweep.plan import Plan
from scenarios.sweep.tables import FIGURES, PERCENTILES

AFTER = LINES[0]
LOW, MIDDLE, HIGH = PERCENTILES
BAND = f"{LOW} to {HIGH} % of the cases"


def draw(plan: Plan, table: pd.DataFrame, bands: pd.DataFrame, folder: Path) -> list[str]:
    """Write a figure for each variant and return the names of the files.

    Left, one row per axis: drift and error at the tool tip over time, median and band of the cases.
    Right: the largest error of each case over the first number that varies; if there is none, in
    order of size.
    """
    files = []
    for number, (variant, title) in enumerate(plan.titles.items()):
        mine = table[(table["variant"] == variant) & (table["problem"] == "")]
        if mine.empty:
            continue
        name = "percentiles.png" if number == 0 else f"percentiles_{variant}.png"
        whole = plan.scenario.settings.title
        whole += "" if title == whole else f": {title}"
        figure = _figure(whole, mine, bands[bands["variant"] == variant], _across(plan, mine))
        files.append(saved(figure, folder / name).name)
    return files


def _across(plan: Plan, table: pd.DataFrame) -> str:
    """Return the x axis of the right side: the grid's first number, or the first one drawn."""
    labels = sorted(plan.variations, key=lambda entry: entry.is_drawn)
    for entry in labels:
        column = table[entry.label]
        if pd.api.types.is_numeric_dtype(column) and column.nunique() > 1:
            return entry.label
    return ""


def _figure(title: str, table: pd.DataFrame, bands: pd.DataFrame, across: str) -> Figure:
    axes = list(dict.fromkeys(table["axis"]))
    figure = Figure(figsize=(11.0, 1.3 + 2.4 * len(axes)), layout="constrained")
    cases = table["case"].nunique()
    figure.suptitle(f"{title} ({cases} cases)", fontsize=12, x=0.01, ha="left")
    grid = figure.subplots(
        len(axes), 2, squeeze=False, sharex="col", gridspec_kw={"width_ratios": (3, 2)}
    )
    for (left, right), axis in zip(grid, axes, strict=True):
        _over_time(left, bands, axis)
        _over_cases(right, table[table["axis"] == axis], across)
        for ax in (left, right):
            ax.set_ylabel(f"{axis} [µm]")
    grid[-1][0].set_xlabel("time [h]")
    grid[-1][1].set_xlabel(across or "share of the cases [%]")
    grid[0][0].set_title("at the tool tip, over the run", fontsize=10, loc="left")
    grid[0][1].set_title("largest of each case", fontsize=10, loc="left")
    handles, labels = grid[0][0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=2, frameon=False, fontsize=9)
    return figure


def _over_time(ax: Axes, bands: pd.DataFrame, axis: str) -> None:
    hours = bands["time_s"] / 3600.0
    for what, label, colour in (
        ("drift", "without compensation", BEFORE),
        ("error", "with compensation", AFTER),
    ):
        low, middle, high = (bands[f"{what}_{axis}_p{p}_um"] for p in PERCENTILES)
        ax.fill_between(
            hours, low, high, color=colour, alpha=0.25, linewidth=0, label=f"{label}, {BAND}"
        )
        ax.plot(hours, middle, color=colour, linewidth=1.4, label=f"{label}, middle")
    ax.margins(x=0.0)
    plain(ax)


def _over_cases(ax: Axes, rows: pd.DataFrame, across: str) -> None:
    for name, colour in ((FIGURES[0], BEFORE), (FIGURES[2], AFTER)):
        if across:
            x, y = rows[across].astype(float), rows[name]
        else:
            y = rows[name].sort_values()
            x = pd.Series((np.arange(len(y)) + 0.5) / len(y) * 100.0)
        ax.plot(x, y, "o", color=colour, markersize=3.0, alpha=0.6, markeredgewidth=0)
    ax.set_ylim(bottom=0.0)
    plain(ax)
