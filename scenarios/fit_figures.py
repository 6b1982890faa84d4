"""Figures of what a fit found: autocorrelations of a time series."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from scenarios.figures import DPI
from scenarios.results import results_folder, write_table


def draw_series(found: Mapping[str, Any], out: Path | None) -> list[Path]:
    """Write ``correlations.png``: ACF and PACF of every series, with the band of white noise.

    Parameters
    ----------
    found : mapping
        What the model reports of its fit; one without ``targets`` with ``acf`` has no figure.
    out : Path, optional
        Folder to write to; none: nothing is drawn.

    Returns
    -------
    list of Path
    """
    targets = found.get("targets")
    series = targets if isinstance(targets, Mapping) else {}
    shown = {name: arma for name, arma in series.items() if "acf" in arma}
    if out is None or not shown:
        return []
    figure = Figure(figsize=(9.0, 1.9 * len(shown)), layout="constrained")
    FigureCanvasAgg(figure)
    axes = figure.subplots(len(shown), 2, squeeze=False, sharex=True, sharey=True)
    for row, (name, arma) in zip(axes, shown.items(), strict=True):
        for ax, key in zip(row, ("acf", "pacf"), strict=True):
            values = np.asarray(arma[key], dtype=float)
            ax.vlines(np.arange(len(values)), 0.0, values, color="#1d5fa8")
            band = arma["white_noise_95"]
            ax.axhspan(-band, band, color="#1d5fa8", alpha=0.15, lw=0)
            ax.set_title(f"{key.upper()} of {name}, differenced {arma['order'][1]} times", size=9)
            ax.spines[["top", "right"]].set_visible(False)
    for ax in axes[-1]:
        ax.set_xlabel(f"lag [steps of {found['step_s']:g} s]")
    with results_folder(out) as folder:
        figure.savefig(folder / "correlations.png", dpi=DPI, metadata={"Software": None})
        write_table([], {"correlations": "correlations.png"}, folder, to_come=())
    return [out / "correlations.png"]
