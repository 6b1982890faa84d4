"""Draws charts as PNG files (matplotlib, without a display)."""

from __future__ import annotations

import io
from pathlib import Path

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from scenarios.pages.charts import CHART_WIDTH, PANEL, Chart, Line, Panel, kept, kept_steps

WIDTH_IN, PANEL_IN = CHART_WIDTH / 100.0, PANEL / 100.0


def draw(chart: Chart, folder: Path) -> Path:
    """Write a chart to ``<name>.png`` in *folder* and return the file."""
    return saved(draw_on(chart, Figure()), folder / f"{chart.name}.png")


def saved(figure: Figure, path: Path) -> Path:
    """Write a figure as a PNG and return its path; the same figure gives the same bytes."""
    path.write_bytes(png_bytes(figure))
    return path


def settle(figure: Figure) -> None:
    """Compute the layout once and keep it to four digits.

    The layout's solver may differ in the last digit from one drawing to the next.

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


def png_bytes(figure: Figure) -> bytes:
    """Return a figure as a PNG; the same figure gives the same bytes.

    Parameters
    ----------
    figure : Figure
        Its layout is settled with `settle`.
    """
    stream = io.BytesIO()
    settle(figure)
    # Without the library's version in the file.
    figure.savefig(stream, format="png", dpi=110, metadata={"Software": None})
    return stream.getvalue()


def draw_on(chart: Chart, figure: Figure) -> Figure:
    """Draw a chart on an empty figure, and return it.

    Parameters
    ----------
    chart : Chart
    figure : Figure
        Empty; its size is set by the chart's panels.

    Returns
    -------
    Figure
        The one given.
    """
    count = len(chart.panels)
    figure.set_size_inches(WIDTH_IN, 1.3 + PANEL_IN * count + (0.9 if count == 1 else 0.0))
    figure.set_layout_engine("constrained")
    figure.suptitle(chart.title, fontsize=12, x=0.01, ha="left")
    axes = figure.subplots(count, 1, sharex=True, squeeze=False)[:, 0]
    for panel, ax in zip(chart.panels, axes, strict=True):
        _draw_panel(panel, ax, chart.x_unit)
    axes[-1].set_xlabel(chart.x_label)
    _legend(figure, chart)
    return figure


def _draw_panel(panel: Panel, ax: Axes, x_unit: float) -> None:
    for line in panel.lines:
        places = kept_steps(line.values) if line.held else kept(line.values)
        ax.plot(
            line.time_s[places] / x_unit,
            line.values[places],
            color=line.colour,
            linewidth=0.7 if line.thin else 1.4,
            zorder=2.0 + 0.1 * line.rank,
            drawstyle="steps-post" if line.held else "default",
            label=line.label,
        )
    ax.set_ylabel(panel.y_label)
    ax.margins(x=0.0)
    ax.set_yscale("log" if panel.log else "linear")
    if panel.from_zero:
        ax.set_ylim(bottom=min(0.0, ax.get_ylim()[0] if ax.dataLim.y0 < 0.0 else 0.0))
    plain(ax)


def plain(ax: Axes) -> None:
    """Give axes the style of all charts: a light grid and no frame."""
    ax.grid(True, color="#e3e6ea", linewidth=0.8)
    ax.spines[["top", "right"]].set_visible(False)
    ax.spines[["left", "bottom"]].set_color("#9aa1ab")
    ax.tick_params(colors="#4a505a", labelsize=9)


def _legend(figure: Figure, chart: Chart) -> None:
    """Put one legend below the whole figure, with each label once."""
    lines: dict[str, Line] = {
        line.label: line for panel in chart.panels for line in panel.lines if line.label
    }
    if len(lines) < 2:
        return
    handles = {
        label: handle
        for ax in figure.axes
        for handle, label in zip(*ax.get_legend_handles_labels(), strict=True)
    }
    for columns in range(min(len(handles), 6 if len(handles) > 4 else 3), 0, -1):
        legend = figure.legend(
            handles.values(),
            handles.keys(),
            loc="outside lower center",
            ncols=columns,
            frameon=False,
            fontsize=9,
        )
        if columns == 1 or legend.get_window_extent().width <= figure.bbox.width:
            return
        legend.remove()
