"""The picture at the top of the gap page: gap before and after by channel, and the reference."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from scenarios.charts import BEFORE, LINES
from scenarios.svg import part, picture

BARS = (("before", "calibrated as given", BEFORE), ("after", "with what was added", LINES[0]))
REFERENCE = "#b8435c"
WIDTH, NAME, NUMBERS, BAR = 720, 130, 90, 7
"""Widths of the picture, its names and its numbers, and height of a bar [px]: set on no data."""


def gap_picture(channels: Mapping[str, Mapping[str, Any]]) -> str:
    """Return the picture as SVG: two bars per channel, and a mark at the reference.

    One bar per channel if nothing was added.

    Parameters
    ----------
    channels : mapping of str to mapping
        As in ``gap.json``; each is drawn in units of its own noise.
    """
    rows = {
        name: {
            key: float(row[key]) / float(row["noise"]) for key in ("before", "after", "reference")
        }
        for name, row in channels.items()
    }
    most = max((value for row in rows.values() for value in row.values()), default=1.0)
    scale = (WIDTH - NAME - NUMBERS) / max(most, 1e-9)
    bars = BARS if any(row["before"] != row["after"] for row in rows.values()) else BARS[:1]
    each = len(bars) * BAR + 6
    height = 26 + each * len(rows)
    parts = _legend(bars)
    for i, (name, row) in enumerate(rows.items()):
        top = 26 + i * each
        line = top + 4 + len(bars) * BAR // 2
        parts.append(part("text", name, x=NAME - 6, y=line, text_anchor="end"))
        for j, (key, _, colour) in enumerate(bars):
            size = {"width": max(row[key] * scale, 0.5), "height": BAR - 1}
            title = f"{name} {key}: {row[key]:.2f}"
            place = {"x": NAME, "y": top + j * BAR}
            parts.append(part("rect", "", title, **place, **size, fill=colour))
        at = NAME + row["reference"] * scale
        ends = {"x1": at, "x2": at, "y1": top - 1, "y2": top + len(bars) * BAR}
        parts.append(part("line", **ends, stroke=REFERENCE, stroke_width=2))
        numbers = " → ".join(f"{row[key]:.1f}" for key, _, _ in bars)
        parts.append(part("text", numbers, x=NAME + max(row.values()) * scale + 6, y=line))
    looks = {"width": "100%", "font_size": 11, "fill": "currentColor"}
    return picture(WIDTH, height, "gap before and after by channel", parts, **looks)


def _legend(bars: Sequence[tuple[str, str, str]]) -> list[str]:
    told = [*((words, colour) for _, words, colour in bars), ("reference", REFERENCE)]
    parts = []
    for i, (words, colour) in enumerate(told):
        x = NAME + 170 * i
        parts.append(part("rect", x=x, y=6, width=12, height=8, fill=colour))
        parts.append(part("text", words, x=x + 17, y=14))
    return parts
