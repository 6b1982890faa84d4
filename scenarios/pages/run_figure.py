"""The figure of a run: speed, temperatures, displacements, tilt."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import cycle, product
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from measurement.faults.fault import STANDING
from measurement.iso230 import FIRST_S, Summary
from measurement.rig import FivePointRig, Rig, axis_of
from measurement.runs import FloatArray, Run
from measurement.units import UNITS, split_column
from scenarios.pages.charts import with_gaps

AXIS_COLOURS = {"X": "#0072b2", "Y": "#009e73", "Z": "#d55e00"}
"""One colour per machine axis in every figure; also distinct for colour-blind readers."""

_OTHER_COLOURS = ("#cc79a7", "#56b4e9", "#e69f00", "#999999", "#f0e442", "#000000")
_TEMPERATURE_COLOURS = (
    *("#1f77b4", "#ff7f0e", "#2ca02c", "#d62728", "#9467bd", "#8c564b"),
    *("#e377c2", "#7f7f7f", "#bcbd22", "#17becf", "#393b79", "#ad494a"),
)
_STYLES: tuple[Any, ...] = ("-", "--", ":")  # Any, since matplotlib wants its own list of literals
Curve = tuple[FloatArray, dict[str, Any]]
"""Values, and their style."""


def draw_overview(
    run: Run, summary: Summary, rig: Rig | None = None, *, figure: Figure | None = None
) -> Figure:
    """Return a figure of a run, one panel per kind of signal that it has.

    Spans in which a displacement looks frozen or saturated are shaded.

    Parameters
    ----------
    run : Run
        The run.
    summary : Summary
        Its summary: the running period and the findings.
    rig : FivePointRig or DirectRig, optional
        Defines the axes of the displacement columns; a five-point rig that fits adds the tilt.
    figure : Figure, optional
        An empty figure to draw on.
    """
    curves = {
        "temperature [°C]": (2.4, _temperatures(run)),
        "displacement [µm]": (2.0, _displacements(run, summary)),
        "tilt [µrad]": (1.4, _tilt(run, rig)),
    }
    panels = [(height, label, lines) for label, (height, lines) in curves.items() if lines]
    turns = bool(run.of_unit("rpm") or run.of_unit("mm_min"))
    if not (panels or turns):  # a run of other signals only still gets a figure
        panels = [(2.0, "", _others(run))]
    heights = [1.0] * turns + [height for height, _, _ in panels]
    figure = figure or Figure()
    figure.set_size_inches(11.0, 1.0 + 1.75 * sum(heights))
    figure.set_layout_engine("constrained")
    every: list[Axes] = figure.subplots(
        len(heights), 1, sharex=True, squeeze=False, gridspec_kw={"height_ratios": heights}
    )[:, 0].tolist()
    if turns:
        _draw_speed(every[0], run)
    for axes, (_, label, lines) in zip(every[turns:], panels, strict=True):
        for values, style in lines:
            _line(axes, run, values, **style)
        if label.startswith("displacement"):
            for number, (start, end) in enumerate(_suspect(summary)):
                said = "frozen or saturated" if number == 0 else None
                span = (start / 60.0, end / 60.0)
                axes.axvspan(*span, color="#d62728", alpha=0.12, linewidth=0, label=said)
        axes.set_ylabel(label)
        _legend(axes)
    for axes in every:
        axes.grid(True, color="#e6e6e6", linewidth=0.8)
        axes.set_axisbelow(True)
        axes.spines[["top", "right"]].set_visible(False)
        _mark_first_hour(axes, run, summary, named=axes is every[0])
    every[-1].set_xlabel("time [min]")
    every[-1].set_xlim(run.time_s[0] / 60.0, max(run.time_s[-1], run.time_s[0] + 1) / 60.0)
    classified = any(segment.state != "unknown" for segment in summary.segments)
    figure.suptitle(f"{run.name}: {summary.test}" if classified else run.name, fontsize=12)
    return figure


def _line(axes: Axes, run: Run, values: FloatArray, **style: Any) -> None:
    """Draw a signal; the line bridges single missing samples, but not pauses or longer gaps."""
    time, drawn = with_gaps(run.time_s, values)
    axes.plot(time / 60.0, drawn, marker="." if np.isfinite(drawn).sum() < 3 else None, **style)


def _draw_speed(axes: Axes, run: Run) -> None:
    speeds, feeds = run.of_unit("rpm"), run.of_unit("mm_min")
    other = axes.twinx() if speeds and feeds else axes
    handles = []
    for names, on, styles, colour, beside in (
        (speeds, axes, _STYLES, "#333333", ""),
        (feeds, other, _STYLES[1:], "#a05a00", " (right)" if speeds else ""),
    ):
        for name, style in zip(names, styles, strict=False):
            values = run.frame[name].to_numpy()
            on.step(run.time_s / 60.0, values, where="post", color=colour, linestyle=style)
            label = split_column(name)[0] + beside
            handles.append(Line2D([], [], color=colour, linestyle=style, label=label))
    if speeds:
        axes.set_ylabel("speed [r/min]")
        axes.set_ylim(bottom=min(0.0, axes.get_ylim()[0]))
    if feeds:
        other.set_ylabel("feed [mm/min]", color="#a05a00")
        other.set_ylim(bottom=min(0.0, other.get_ylim()[0]))
        other.spines["top"].set_visible(False)
    _legend(axes, handles, right=1.075 if speeds and feeds else 1.01)


def _temperatures(run: Run) -> list[Curve]:
    looks = product(_STYLES, _TEMPERATURE_COLOURS)
    return [
        _curve(run, name, linewidth=1.1, color=colour, linestyle=style)
        for name, (style, colour) in zip(run.temperatures, cycle(looks), strict=False)
    ]


def _displacements(run: Run, summary: Summary) -> list[Curve]:
    spare, curves = cycle(_OTHER_COLOURS), []
    for name in run.displacements:
        signal, place = split_column(name)[0], summary.places.get(name, "")
        axis = _axis(signal, place)
        style = "--" if place.startswith("distal") or signal.startswith("error") else "-"
        look = {
            "color": AXIS_COLOURS[axis] if axis else next(spare),
            "linestyle": ":" if signal.startswith("offset") else style,
            "label": f"{signal} ({place})" if place else signal,
        }
        curves.append(_curve(run, name, linewidth=1.3, **look))
    return curves


def _tilt(run: Run, rig: Rig | None) -> list[Curve]:
    if not (isinstance(rig, FivePointRig) and rig.fits(run)):
        return []
    pose = rig.pose(run.frame)
    look = {"linewidth": 1.3}
    return [
        (pose["yaw_urad"].to_numpy(), look | {"color": AXIS_COLOURS["X"], "label": "yaw (XZ)"}),
        (pose["pitch_urad"].to_numpy(), look | {"color": AXIS_COLOURS["Y"], "label": "pitch (YZ)"}),
    ]


def _others(run: Run) -> list[Curve]:
    curves = []
    for name, colour in zip(map(str, run.frame.columns[1:]), _OTHER_COLOURS, strict=False):
        signal, unit = split_column(name)
        curves.append(_curve(run, name, color=colour, label=f"{signal} [{UNITS[unit].label}]"))
    return curves


def _curve(run: Run, name: str, **look: Any) -> Curve:
    return run.frame[name].to_numpy(), {"label": split_column(name)[0], **look}


def _axis(signal: str, place: str) -> str:
    """Return the axis of a displacement from its place in the rig, else its name, else empty."""
    if place == "axial":
        return "Z"
    if place[-1:] in AXIS_COLOURS:
        return place[-1]
    axis = axis_of(signal)
    return axis[0] if axis else ""


def _suspect(summary: Summary) -> list[tuple[float, float]]:
    """Return the spans in which a displacement was wrongly constant, overlaps merged [s]."""
    joined: list[tuple[float, float]] = []
    for start, end in sorted(
        (part.start_s, part.end_s) for part in summary.findings if part.kind in STANDING
    ):
        if joined and start <= joined[-1][1]:
            joined[-1] = (joined[-1][0], max(end, joined[-1][1]))
        else:
            joined.append((start, end))
    return joined


def _mark_first_hour(axes: Axes, run: Run, summary: Summary, *, named: bool) -> None:
    start = summary.running_period_s[0] if summary.running_period_s else float(run.time_s[0])
    at = start + FIRST_S
    if at >= run.time_s[-1]:
        return
    place = at / 60.0
    axes.axvline(place, color="#888888", linewidth=0.9, linestyle=(0, (4, 3)))
    if named:
        axes.annotate(
            "60 min",
            (place, 1.0),
            xycoords=("data", "axes fraction"),
            xytext=(2, 1),
            textcoords="offset points",
            fontsize=7,
            color="#666666",
        )


def _legend(axes: Axes, handles: Sequence[Line2D] | None = None, right: float = 1.01) -> None:
    """Put the legend next to the panel, where it covers no data."""
    entries: Any = handles if handles is not None else axes.get_legend_handles_labels()[0]
    if not entries:
        return
    axes.legend(
        handles=entries,
        loc="upper left",
        bbox_to_anchor=(right, 1.0),
        ncols=1 + (len(entries) - 1) // len(_TEMPERATURE_COLOURS),
        fontsize=8,
        frameon=False,
        borderaxespad=0.0,
    )
