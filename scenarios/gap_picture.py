"""The gap before and after by channel, beside the reference: the picture at the top of the page."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from html import escape
from typing import Any

from scenarios.charts import BEFORE, LINES

BARS = (("before", "calibrated as given", BEFORE), ("after", "with what was added", LINES[0]))
REFERENCE = "#b8435c"
WIDTH, NAME, NUMBERS, BAR = 720, 130, 90, 7
"""Of the picture, of names and numbers in it, and the height of a bar [px]."""


def gap_picture(channels: Mapping[str, Mapping[str, Any]]) -> str:
    """Return the picture as SVG: two bars for each channel, and a mark where the reference is.

    One bar where nothing was added.

    Parameters
    ----------
    channels : mapping of str to mapping
        As ``gap.json`` has them; each is drawn in units of its own noise.
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
    parts = [
        f'<svg viewBox="0 0 {WIDTH} {height}" width="100%" role="img" '
        'aria-label="gap before and after by channel" font-size="11" fill="currentColor">',
        *_legend(bars),
    ]
    for i, (name, row) in enumerate(rows.items()):
        top = 26 + i * each
        line = top + 4 + len(bars) * BAR // 2
        parts.append(f'<text x="{NAME - 6}" y="{line}" text-anchor="end">{escape(name)}</text>')
        for j, (key, _, colour) in enumerate(bars):
            long = max(row[key] * scale, 0.5)
            parts.append(
                f'<rect x="{NAME}" y="{top + j * BAR}" width="{long:.1f}" height="{BAR - 1}" '
                f'fill="{colour}"><title>{escape(name)} {key}: {row[key]:.2f}</title></rect>'
            )
        at = NAME + row["reference"] * scale
        parts.append(
            f'<line x1="{at:.1f}" x2="{at:.1f}" y1="{top - 1}" y2="{top + len(bars) * BAR}" '
            f'stroke="{REFERENCE}" stroke-width="2"/>'
        )
        end = NAME + max(row.values()) * scale + 6
        numbers = " → ".join(f"{row[key]:.1f}" for key, _, _ in bars)
        parts.append(f'<text x="{end:.1f}" y="{line}">{numbers}</text>')
    return "".join([*parts, "</svg>"])


def _legend(bars: Sequence[tuple[str, str, str]]) -> list[str]:
    told = [*((words, colour) for _, words, colour in bars), ("reference", REFERENCE)]
    parts = []
    for i, (words, colour) in enumerate(told):
        x = NAME + 170 * i
        parts.append(f'<rect x="{x}" y="6" width="12" height="8" fill="{colour}"/>')
        parts.append(f'<text x="{x + 17}" y="14">{words}</text>')
    return parts
