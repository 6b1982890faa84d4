"""The figure that shows a run: speed, temperatures, displacements, tilt."""

from __future__ import annotations

import io
from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from measurement.faults.fault import STANDING
from measurement.iso230 import FIRST_S, Summary
from measurement.resampling import GAP_INTERVALS
from measurement.rig import FivePointRig, Rig, axis_of
from measurement.runs import FloatArray, Run
from measurement.units import UNITS, split_column

AXIS_COLOURS = {"X": "#0072b2", "Y": "#009e73", "Z": "#d55e00"}
"""One colour per machine axis in every figure; they differ for colour-blind readers too."""

_OTHER_COLOURS = ("#cc79a7", "#56b4e9", "#e69f00", "#999999", "#f0e442", "#000000")
_TEMPERATURE_COLOURS = (
    *("#1f77b4", "#ff7f0e", "#2ca02c", "#d62728", "#9467bd", "#8c564b"),
    *("#e377c2", "#7f7f7f", "#bcbd22", "#17becf", "#393b79", "#ad494a"),
)
_STYLES: tuple[Any, ...] = ("-", "--", ":")  # Any, since matplotlib wants its own list of literals


def draw_overview(
    run: Run, summary: Summary, rig: Rig | None = None, *, figure: Figure | None = None
) -> Figure:
    """Return a figure of a run, one panel per kind of signal that it has.

    Stretches in which a displacement looks frozen or saturated are shaded.

    Parameters
    ----------
    run : Run
        What to draw.
    summary : Summary
        Its summary: the running period and the findings.
    rig : FivePointRig or DirectRig, optional
        Gives the displacement columns their axes; a five-point rig that fits adds the tilt.
    figure : Figure, optional
        Empty, to draw on.
    """
    five_point = rig if isinstance(rig, FivePointRig) and rig.fits(run) else None
    panels = [
        (bool(run.of_unit("rpm") or run.of_unit("mm_min")), 1.0, _draw_speed),
        (bool(run.temperatures), 2.4, _draw_temperatures),
        (bool(run.displacements), 2.0, _draw_displacements),
        (five_point is not None, 1.4, _draw_tilt),
    ]
    shown = [(height, draw) for there, height, draw in panels if there]
    if not shown:  # a run of other signals only: still a figure, with nothing hidden
        shown = [(2.0, _draw_others)]
    heights = [height for height, _ in shown]
    figure = figure or Figure()
    figure.set_size_inches(11.0, 1.0 + 1.75 * sum(heights))
    figure.set_layout_engine("constrained")
    grid = figure.subplots(
        len(shown), 1, sharex=True, squeeze=False, gridspec_kw={"height_ratios": heights}
    )
    for axes, (_, draw) in zip(grid[:, 0], shown, strict=True):
        draw(axes, run, summary, rig)
        axes.grid(True, color="#e6e6e6", linewidth=0.8)
        axes.set_axisbelow(True)
        axes.spines[["top", "right"]].set_visible(False)
        _mark_first_hour(axes, run, summary, named=axes is grid[0, 0])
    grid[-1, 0].set_xlabel("time [min]")
    grid[-1, 0].set_xlim(run.time_s[0] / 60.0, max(run.time_s[-1], run.time_s[0] + 1) / 60.0)
    known = any(segment.state != "unknown" for segment in summary.segments)
    figure.suptitle(f"{run.name}: {summary.test}" if known else run.name, fontsize=12)
    return figure


def settle(figure: Figure) -> None:
    """Let the layout take place once and keep it to four digits.

    The layout's solver may end a last digit apart from one drawing to the next.

    Parameters
    ----------
    figure : Figure
        Changed in place.
    """
    figure.draw_without_rendering()
    places = [(axes, axes.get_position().bounds) for axes in figure.axes]
    figure.set_layout_engine("none")
    for axes, (left, bottom, width, height) in places:
        axes.set_position((round(left, 4), round(bottom, 4), round(width, 4), round(height, 4)))


def png_bytes(figure: Figure, dpi: int = 110) -> bytes:
    """Return a figure as a PNG; the same figure gives the same bytes.

    Parameters
    ----------
    figure : Figure
        Its layout is settled, as `settle` does.
    dpi : int
        Pixels per inch.
    """
    stream = io.BytesIO()
    settle(figure)
    # Without the library's version in it.
    figure.savefig(stream, format="png", dpi=dpi, metadata={"Software": None})
    return stream.getvalue()


def _line(axes: Axes, run: Run, values: FloatArray, **style: Any) -> None:
    """Draw a signal; a line bridges single missing samples, not pauses or longer gaps."""
    there = ~np.isnan(values)
    time, drawn, shown = run.time_s[there], values[there], run.time_s[there] / 60.0
    if time.size > 1:
        cuts = np.flatnonzero(np.diff(time) > GAP_INTERVALS * np.median(np.diff(time))) + 1
        shown, drawn = np.insert(shown, cuts, np.nan), np.insert(drawn, cuts, np.nan)
    axes.plot(shown, drawn, marker="." if time.size < 3 else None, **style)


def _draw_speed(axes: Axes, run: Run, summary: Summary, rig: Rig | None) -> None:
    speeds, feeds = run.of_unit("rpm"), run.of_unit("mm_min")
    for name, style in zip(speeds, _STYLES, strict=False):
        values = run.frame[name].to_numpy()
        axes.step(run.time_s / 60.0, values, where="post", color="#333333", linestyle=style)
    if speeds:
        axes.set_ylabel("speed [r/min]")
        axes.set_ylim(bottom=min(0.0, axes.get_ylim()[0]))
    handles = [Line2D([], [], color="#333333", label=split_column(name)[0]) for name in speeds]
    other = axes.twinx() if speeds and feeds else axes
    for name, style in zip(feeds, _STYLES[1:], strict=False):
        colour = "#a05a00"
        values = run.frame[name].to_numpy()
        other.step(run.time_s / 60.0, values, where="post", color=colour, linestyle=style)
        label = f"{split_column(name)[0]}" + (" (right)" if speeds else "")
        handles.append(Line2D([], [], color=colour, linestyle=style, label=label))
    if feeds:
        other.set_ylabel("feed [mm/min]", color="#a05a00")
        other.set_ylim(bottom=min(0.0, other.get_ylim()[0]))
        other.spines["top"].set_visible(False)
    _legend(axes, handles, right=1.075 if speeds and feeds else 1.01)


def _draw_temperatures(axes: Axes, run: Run, summary: Summary, rig: Rig | None) -> None:
    for i, name in enumerate(run.temperatures):
        _line(
            axes,
            run,
            run.frame[name].to_numpy(),
            color=_TEMPERATURE_COLOURS[i % len(_TEMPERATURE_COLOURS)],
            linestyle=_STYLES[i // len(_TEMPERATURE_COLOURS) % len(_STYLES)],
            linewidth=1.1,
            label=split_column(name)[0],
        )
    axes.set_ylabel("temperature [°C]")
    _legend(axes)


def _draw_displacements(axes: Axes, run: Run, summary: Summary, rig: Rig | None) -> None:
    spare = iter(_OTHER_COLOURS * (1 + len(run.displacements) // len(_OTHER_COLOURS)))
    for name in run.displacements:
        signal = split_column(name)[0]
        place = summary.places.get(name, "")
        axis = _axis(signal, place)
        style = "--" if place.startswith("distal") or signal.startswith("error") else "-"
        _line(
            axes,
            run,
            run.frame[name].to_numpy(),
            color=AXIS_COLOURS[axis] if axis else next(spare),
            linestyle=":" if signal.startswith("offset") else style,
            linewidth=1.3,
            label=f"{signal} ({place})" if place else signal,
        )
    for number, (start, end) in enumerate(_suspect(summary)):
        axes.axvspan(
            start / 60.0,
            end / 60.0,
            color="#d62728",
            alpha=0.12,
            linewidth=0,
            label="frozen or saturated" if number == 0 else None,
        )
    axes.set_ylabel("displacement [µm]")
    _legend(axes)


def _axis(signal: str, place: str) -> str:
    """Return the axis of a displacement by its place in the rig, else by its name, else nothing."""
    if place == "axial":
        return "Z"
    if place[-1:] in AXIS_COLOURS:
        return place[-1]
    found = axis_of(signal)
    return found[0] if found else ""


def _suspect(summary: Summary) -> list[tuple[float, float]]:
    """Return when any displacement stood still that should not, overlaps joined [s]."""
    joined: list[tuple[float, float]] = []
    for start, end in sorted(
        (part.start_s, part.end_s) for part in summary.findings if part.kind in STANDING
    ):
        if joined and start <= joined[-1][1]:
            joined[-1] = (joined[-1][0], max(end, joined[-1][1]))
        else:
            joined.append((start, end))
    return joined


def _draw_tilt(axes: Axes, run: Run, summary: Summary, rig: Rig | None) -> None:
    if not isinstance(rig, FivePointRig):
        return
    pose = rig.pose(run.frame)
    for name, axis, plane in (("yaw_urad", "X", "XZ"), ("pitch_urad", "Y", "YZ")):
        label = f"{split_column(name)[0]} ({plane})"
        values = pose[name].to_numpy()
        _line(axes, run, values, color=AXIS_COLOURS[axis], linewidth=1.3, label=label)
    axes.set_ylabel("tilt [µrad]")
    _legend(axes)


def _draw_others(axes: Axes, run: Run, summary: Summary, rig: Rig | None) -> None:
    names = [str(name) for name in run.frame.columns[1:]]
    for name, colour in zip(names, _OTHER_COLOURS, strict=False):
        signal, unit = split_column(name)
        label = f"{signal} [{UNITS[unit].label}]"
        _line(axes, run, run.frame[name].to_numpy(), color=colour, label=label)
    if names:
        _legend(axes)


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
    """Put the legend beside the panel, where it covers no data."""
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
