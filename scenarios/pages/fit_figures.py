"""Figures of a fit: autocorrelations of a time series, convergence of a network."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from scenarios.pages.charts import LINES, convergence_chart
from scenarios.pages.figures import draw_on, saved
from scenarios.results import results_folder, write_table

Details = Mapping[str, Any]


def draw_fit(details: Details, out: Path) -> list[Path]:
    """Write the figures that a fit has.

    Parameters
    ----------
    details : mapping
        The error model's report on its fit.
    out : Path
        Folder to write to; untouched if there is no figure.

    Returns
    -------
    list of Path
    """
    figures = {"correlations": _correlations(details), "convergence": _convergence(details)}
    drawn = {name: figure for name, figure in figures.items() if figure is not None}
    if not drawn:
        return []
    with results_folder(out) as folder:
        for name, figure in drawn.items():
            saved(figure, folder / f"{name}.png")
        write_table([], {name: f"{name}.png" for name in drawn}, folder)
    return [out / f"{name}.png" for name in drawn]


def _correlations(details: Details) -> Figure | None:
    """Return the ACF and PACF of every series, with the band of white noise."""
    targets = details.get("targets")
    series = targets if isinstance(targets, Mapping) else {}
    shown = {name: arma for name, arma in series.items() if "acf" in arma}
    if not shown:
        return None
    figure = Figure(figsize=(9.0, 1.9 * len(shown)), layout="constrained")
    axes = figure.subplots(len(shown), 2, squeeze=False, sharex=True, sharey=True)
    for row, (name, arma) in zip(axes, shown.items(), strict=True):
        for ax, key in zip(row, ("acf", "pacf"), strict=True):
            values = np.asarray(arma[key], dtype=float)
            ax.vlines(np.arange(len(values)), 0.0, values, color=LINES[0])
            band = arma["white_noise_95"]
            ax.axhspan(-band, band, color=LINES[0], alpha=0.15, lw=0)
            ax.set_title(f"{key.upper()} of {name}, differenced {arma['order'][1]} times", size=9)
            ax.spines[["top", "right"]].set_visible(False)
    for ax in axes[-1]:
        ax.set_xlabel(f"lag [steps of {details['step_s']:g} s]")
    return figure


def _convergence(details: Details) -> Figure | None:
    """Return the mean squared error of a network over the iterations of its training."""
    if "curve" not in details:
        return None
    shape = "-".join(map(str, details["nodes"]))
    title = f"network {shape}, {details['iterations']} iterations"
    return draw_on(convergence_chart({title: details["curve"]}), Figure())
