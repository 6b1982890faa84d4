"""The figure of a monitoring report: error by run, compared with the promised one."""

from __future__ import annotations

from pathlib import Path
from textwrap import fill

from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from fmu_compensator.monitoring import Report
from fmu_compensator.monitoring.drift import AxisError
from fmu_compensator.monitoring.monitor import (
    CHANGED,
    FITS,
    LEARNT,
    NOT_MEASURED,
    OUTSIDE,
    SENSOR,
    TOO_SHORT,
    RunReport,
)
from scenarios.pages.figures import PANEL_IN, WIDTH_IN, plain, saved

DOTS = {
    FITS: {"color": "#2a7f4f", "label": "fits"},
    LEARNT: {"color": "#9aa3ad", "label": "learnt from"},
    NOT_MEASURED: {"color": "#7a828c", "label": "not measured"},
    OUTSIDE: {"color": "#c98a1b", "label": "outside training"},
    CHANGED: {"color": "#b3342d", "label": "more than promised"},
    SENSOR: {"color": "#6a3fa0", "label": "a thermometer"},
    TOO_SHORT: {"color": "#7a828c", "label": "too short"},
}


def draw_monitor(report: Report, folder: Path) -> list[Path]:
    """Draw each axis' error over the promised half-width, run by run, coloured by its verdict.

    Parameters
    ----------
    report : Report
    folder : Path
        Folder for ``monitor.png``.

    Returns
    -------
    list of Path
    """
    axes = sorted({error.axis for run in report.runs for error in run.errors})
    figure = Figure(figsize=(WIDTH_IN, 1.8 + PANEL_IN * max(len(axes), 1)), layout="constrained")
    title = fill(f"{report.verdict}: {report.summary}", 100)
    figure.suptitle(title, fontsize=12, x=0.01, ha="left")
    panels = figure.subplots(max(len(axes), 1), 1, sharex=True, squeeze=False)[:, 0]
    used = []
    for panel, axis in zip(panels, axes, strict=False):
        bound = 1.0
        for place, run in enumerate(report.runs):
            for error in run.errors:
                if error.axis == axis:
                    bound = error.bound
                    used.append(axis_verdict(run, error))
                    panel.plot(place, error.miss, "o", color=DOTS[used[-1]]["color"])
                    panel.annotate(
                        _label(error), (place, error.miss), (0, 6), textcoords="offset points",
                        fontsize=7, ha="center", color="#4a505a",
                    )  # fmt: skip
        panel.axhline(bound, color="#b3342d", linestyle="--", linewidth=1.0)
        panel.set_ylabel(f"{axis}: error / promised\nhalf width [1]")
        panel.set_ylim(bottom=0.0, top=max(bound, panel.get_ylim()[1]) * 1.25)
        panel.margins(x=0.05)
        plain(panel)
    if not axes:
        panels[0].text(0.5, 0.5, "the drift was not measured", ha="center", va="center")
        panels[0].set_axis_off()
    if axes:
        # As many of them are named as fit.
        names = {place: run.run for place, run in enumerate(report.runs)}
        panels[-1].xaxis.set_major_locator(MaxNLocator("auto", integer=True))
        panels[-1].xaxis.set_major_formatter(lambda at, _: names.get(at, ""))
        panels[-1].tick_params("x", labelrotation=60)
        panels[0].set_title(
            "at each run: remaining error / drift [µm RMSE]",
            fontsize=8,
            color="#4a505a",
            loc="left",
        )
    for verdict in dict.fromkeys(used):
        panels[0].plot([], [], "o", **DOTS[verdict])
    if axes:
        panels[0].plot([], [], "--", color="#b3342d", label="more is unlike training")
        figure.legend(loc="outside lower center", ncols=4, fontsize=9, frameon=False)
    return [saved(figure, folder / "monitor.png")]


def axis_verdict(run: RunReport, error: AxisError) -> str:
    """Return a run's verdict for one axis; the machine may have changed along another."""
    return FITS if run.verdict == CHANGED and not error.is_unusual else run.verdict


def _label(error: AxisError) -> str:
    return f"{error.left:.1f} / {error.none:.1f}"
