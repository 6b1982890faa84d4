"""Charts that compare a machine's model with measurements, channel by channel."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from gap_finder.regimes import RunResiduals
from scenarios.pages.charts import BEFORE, LINES, MEASURED, Chart, Line, Panel


def channel_charts(
    shown: RunResiduals,
    lines_of: Callable[[int], tuple[Line, ...]],
    *,
    name: str,
    title: str,
    note: str,
    degrees: str = "K",
) -> list[Chart]:
    """Return charts of one run with a panel per channel: temperatures, then displacements.

    Parameters
    ----------
    shown : RunResiduals
        Defines which channels were measured.
    lines_of : callable
        From a channel's index to its curves.
    name, title, note : str
        Texts of the charts; contents and run are added to name and title.
    degrees : str
        Unit of temperatures: of differences, or as a thermometer reads.
    """
    observed = shown.observed
    charts = []
    for kind, unit, is_length in (("temperatures", degrees, False), ("displacements", "µm", True)):
        panels = [
            Panel(f"{channel} [{unit}]", lines_of(i))
            for i, channel in enumerate(observed.channels)
            if observed.lengths[i] == is_length and np.isfinite(shown.values[:, i]).any()
        ]
        if panels:
            file, shown_as = f"{name}_{kind}_{observed.run.name}", f"{title}, {kind}"
            charts.append(Chart(file, f"{shown_as}: {observed.run.name}", note, tuple(panels)))
    return charts


def measured_against_model(models: Sequence[tuple[str, RunResiduals]], note: str) -> list[Chart]:
    """Return charts of one run: measurements, and the outputs of the named models.

    Parameters
    ----------
    models : sequence of (str, RunResiduals)
        The most important one last.
    note : str
    """
    shown = models[-1][1]
    time, measured = shown.observed.time_s, shown.observed.values
    colours = (BEFORE, LINES[0])[-len(models) :]

    def lines_of(i: int) -> tuple[Line, ...]:
        modelled = [
            Line(name, time, measured[:, i] + residuals.values[:, i], colour, rank=rank)
            for rank, ((name, residuals), colour) in enumerate(zip(models, colours, strict=True), 1)
        ]
        return (*modelled, Line("measured", time, measured[:, i], MEASURED, rank=0))

    return channel_charts(
        shown,
        lines_of,
        name="measured",
        title="Measured against model",
        note=note,
        degrees="°C",
    )
