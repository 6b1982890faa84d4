"""The report: one self-contained HTML file with interactive figures."""

from __future__ import annotations

import base64
import json
import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import jinja2
import markupsafe

from measurement.files import write_atomically
from scenarios.pages.charts import PANEL, Chart, Line, kept, kept_steps
from scenarios.recording import Event
from scenarios.table import number, percent

TEMPLATES = Path(__file__).parent / "templates"
PLOTLY = TEMPLATES / "plotly-basic.min.js.gz"
"""plotly.js-basic-dist-min 4.1.1 from npm, MIT: a quarter of the full library.
A page contains it compressed, and the browser unpacks it."""
CONFIG = {"responsive": True, "displaylogo": False, "displayModeBar": False}
AXIS = {"gridcolor": "#e3e6ea", "linecolor": "#9aa1ab", "zerolinecolor": "#c6cbd2"}
VALUES = AXIS | {"automargin": True, "exponentformat": "none", "separatethousands": True}
LOOKS: dict[str, Any] = {
    "margin": {"l": 58, "r": 14, "t": 12, "b": 44},
    "paper_bgcolor": "rgba(0,0,0,0)",
    "plot_bgcolor": "#ffffff",
    "font": {"family": "system-ui, sans-serif", "size": 12, "color": "#333a44"},
    "hovermode": "x unified",
    "hoverlabel": {"namelength": -1},
    "legend": {"orientation": "h", "yanchor": "bottom", "y": 1.0, "x": 0, "xanchor": "left"},
}
"""Style of every figure: light, few lines, the legend on top."""

STATES = (
    ("ok", "#4f9d69", "following the model"),
    ("outside training", "#c9b458", "following the model outside what it was trained on"),
    ("waiting", "#b9bec6", "waiting for the first valid sample"),
    ("recovering", "#6f9fd0", "moving back to the wanted offset after a fault"),
    ("holding", "#e0a050", "holding the last good offset"),
    ("ramping to zero", "#cf6f45", "giving the offset up slowly"),
    ("at zero", "#a83c4a", "no compensation"),
    ("without a sensor", "#8fae5d", "following the model without a broken sensor"),
)


@dataclass(frozen=True)
class Span:
    """A span of a timeline: its start and width [% of the whole], and its style."""

    left: float
    width: float
    colour: str
    text: str


def write_page(template: str, path: Path, **values: Any) -> Path:
    """Write a page from a template of this package; see `page_text`."""
    return write_atomically(path, page_text(template, **values))


def page_text(template: str, **values: Any) -> str:
    """Return a page from a template of this package: one self-contained HTML file.

    Parameters
    ----------
    template : str
        File name in ``templates``. ``page.html`` is a complete one: kicker, title, lines of text,
        charts and facts; others extend it or ``base.html``.
    **values
        Its contents; with ``charts``, plotly's script is included.
    """
    environment = jinja2.Environment(
        loader=jinja2.FileSystemLoader(TEMPLATES),
        autoescape=True,
        trim_blocks=True,
        lstrip_blocks=True,
        undefined=jinja2.StrictUndefined,
    )
    environment.filters |= {
        "number": number,
        "percent": percent,
        "clock": clock,
        "drawn": chart_html,
        "short": short,
        "g": "{:g}".format,
    }
    environment.globals["plotly"] = lambda: base64.b64encode(PLOTLY.read_bytes()).decode()
    return environment.get_template(template).render(**values)


def chart_html(chart: Chart) -> markupsafe.Markup:
    """Return a chart for the page: its panels stacked over one time axis."""
    count = len(chart.panels)
    labels = {line.label for panel in chart.panels for line in panel.lines} - {""}
    shown: set[str] = set()
    traces = []
    layout: dict[str, Any] = {
        "grid": {"rows": count, "columns": 1, "pattern": "coupled"},
        "xaxis": AXIS | {"showline": True, "title": {"text": chart.x_label}},
        "showlegend": len(labels) > 1,
    }
    for row, panel in enumerate(chart.panels, 1):
        number_of_axis = "" if row == 1 else str(row)
        for line in panel.lines:
            first = bool(line.label) and line.label not in shown
            trace = _trace(line, chart.x_unit, first=first)
            traces.append(trace | {"yaxis": f"y{number_of_axis}"})
            shown.add(line.label)
        layout[f"yaxis{number_of_axis}"] = VALUES | {
            "title": {"text": panel.y_label},
            "rangemode": "tozero" if panel.from_zero else "normal",
            "type": "log" if panel.log else "linear",
        }
    height = PANEL * count + sum(LOOKS["margin"].values()) // 2 + 10 * len(labels)
    element = f"chart-{chart.name}"
    figure = {"data": traces, "layout": LOOKS | layout, "config": CONFIG}
    # A "<" in a name must not end the script.
    text = json.dumps([element, figure], separators=(",", ":")).replace("<", "\\u003c")
    markup = '<div id="{}" class="chart" style="height: {}px"></div>\n'
    drawing = f"<script>plotly.then(() => Plotly.newPlot(...{text}))</script>"
    return markupsafe.Markup(markup).format(element, height) + markupsafe.Markup(drawing)


def short(value: float) -> str:
    """Return an error as text for tables of models: three significant figures, or two decimals."""
    if math.isnan(value):
        return "-"
    return f"{value:.1f}" if value >= 100.0 else f"{value:.2f}"


def clock(seconds: float) -> str:
    """Return a time as hours, minutes and seconds.

    >>> clock(3725)
    '1:02:05'
    """
    whole = round(seconds)
    return f"{whole // 3600}:{whole // 60 % 60:02d}:{whole % 60:02d}"


def _trace(line: Line, x_unit: float, *, first: bool) -> dict[str, Any]:
    places = (kept_steps if line.held else kept)(line.values)
    values = line.values[places].tolist()
    return {
        "type": "scatter",
        "x": (line.time_s[places] / x_unit).round(5).tolist(),
        "y": [None if value != value else float(f"{value:.5g}") for value in values],
        "name": line.label,
        "legendgroup": line.label,
        "showlegend": first,
        "mode": "lines",
        "line": {
            "color": line.colour,
            "width": 1.0 if line.thin else 1.8,
            "shape": "hv" if line.held else "linear",
        },
        "zorder": line.rank,
        "hovertemplate": "%{y:.4g}" + ("" if line.label else "<extra></extra>"),
    }


def state_of(code: int) -> int:
    """Return the index in STATES of a status code of the compensator."""
    if code < 10:
        return {0: 0, 1: 2, 2: 1, 3: 3, 4: 7}.get(code, 3)
    return min(code // 10, 3) + 3


def spans_of(events: Sequence[Event], end_s: float) -> list[Span]:
    """Return the spans of constant state in a timeline, up to *end_s* [s]."""
    spans = []
    stops = [event.time_s for event in events[1:]] + [end_s]
    for event, stop in zip(events, stops, strict=True):
        if end_s <= 0.0:
            break
        name, colour, _ = STATES[state_of(event.code)]
        text = f"{clock(event.time_s)} to {clock(stop)}, {name}: {event.text or 'no message'}"
        left, width = (100.0 * part / end_s for part in (event.time_s, stop - event.time_s))
        spans.append(Span(round(left, 3), round(width, 3), colour, text))
    return spans
