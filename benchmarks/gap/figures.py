"""The confusion matrix, and what is said against how much gap an effect leaves."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from benchmarks.gap.outcome import (
    BROKEN,
    MORE,
    NAMED,
    NONE,
    ONE_EFFECT,
    ONE_OF,
    OPEN_OUTCOMES,
    OUTCOMES,
    RIGHT,
    SAME,
    UNKNOWN,
    WRONG,
    holds,
    tally,
)
from benchmarks.gap.records import STRONG, VISIBLE, Record
from benchmarks.gap.truth.effects import OUTSIDE, catalogue
from measurement.overview import png_bytes

ORDER = (
    "viscosity_temperature",
    "thermal_preload",
    "friction_speed_exponent",
    "bearing_run_in",
    "uneven_bearing_heating",
    "joint_resistance",
    "motor_iron_loss",
    "windage",
    "copper_loss",
    "cutting_heat",
    "forced_convection",
    "natural_convection",
    "radiation",
    "coolant_thermostat",
    "coolant_degradation",
    "coolant_supply_offset",
    "column_bending",
    "slow_structure",
    "fixture_warming",
    "tool_heating",
    "centrifugal_shift",
    "bearing_stick_slip",
    "sensor_lag",
    "sensor_offset",
    "sensor_drift",
)
"""Effects that are likely to be taken for each other stand side by side."""

SET_WITH, SET_WITHOUT = "a set with it", "a set without it"
WRONG_CHANNEL = "it on another sensor"
DESCRIPTION = "a change of the file"
NOT_DRAWN = ("pair", "mistake")
"""Kinds of questions that have no single effect for an answer."""

COLOURS = {
    RIGHT: "#1a7f4b",
    ONE_OF: "#86c89b",
    MORE: "#d9c55a",
    BROKEN: "#5aa7c7",
    UNKNOWN: "#9aa7b8",
    NONE: "#dfe4ea",
    SAME: "#86c89b",
    WRONG: "#c0392b",
    NAMED: "#c0392b",
}
EDGES = (0.0, 1.1, VISIBLE, 1.5, STRONG, 3.0, np.inf)


def _effects() -> list[str]:
    """Return all effects of the catalogue, those that no order is known for last."""
    return [*ORDER, *(name for name in catalogue() if name not in ORDER)]


def answer_of(record: Record) -> str:
    """Return the matrix's column: what is named first, or that nothing is."""
    if not record.groups:
        return record.outcome
    first = record.groups[0]
    truth = record.truth[0] if record.kind in ONE_EFFECT else None
    if len(first) > 1:
        return SET_WITH if truth is not None and holds(first, truth) else SET_WITHOUT
    name = first[0].partition(":")[0]
    if truth is not None and name == truth["name"] and not holds(first, truth):
        return WRONG_CHANNEL
    return name if name in _effects() else DESCRIPTION


def row_of(record: Record) -> str:
    """Return the matrix's row: what is hidden."""
    if record.kind == "none":
        return "nothing"
    if record.kind == "deleted":
        return "deleted from the catalogue"
    return str(record.truth[0]["name"])


def confusion(records: Sequence[Record]) -> tuple[list[str], list[str], np.ndarray]:
    """Return rows, columns and counts, shape (rows, columns); `NOT_DRAWN` kinds are left out."""
    asked = [one for one in records if one.kind not in NOT_DRAWN]
    wrong = (SET_WITH, SET_WITHOUT, WRONG_CHANNEL, DESCRIPTION)
    columns = [*_effects(), *wrong, BROKEN, UNKNOWN, NONE]
    more = (row_of(one) for one in asked if one.kind == "outside")
    rows = [*_effects(), "deleted from the catalogue", *dict.fromkeys((*OUTSIDE, *more)), "nothing"]
    counts = np.zeros((len(rows), len(columns)), dtype=int)
    for one in asked:
        counts[rows.index(row_of(one)), columns.index(answer_of(one))] += 1
    return rows, columns, counts


def strong_confusion_matrix(records: Sequence[Record]) -> bytes:
    """Return the confusion matrix of strong cases, and of those with nothing hidden."""
    return confusion_matrix([r for r in records if r.kind == "none" or r.strength == "strong"])


def confusion_matrix(records: Sequence[Record]) -> bytes:
    """Return the confusion matrix as a PNG: the first name of each answer, counted."""
    rows, columns, counts = confusion(records)
    figure = Figure(figsize=(12.0, 11.6), layout="constrained")
    FigureCanvasAgg(figure)
    axes = figure.subplots()
    totals = np.maximum(counts.sum(axis=1, keepdims=True), 1)
    axes.imshow(_shades(rows, columns, counts / totals), aspect="auto")
    for i, j in np.argwhere(counts > 0):
        dark = counts[i, j] / totals[i, 0] > 0.55
        axes.text(
            j, i, str(counts[i, j]), ha="center", va="center", color="white" if dark else "#222"
        )
    _label(axes, rows, columns, counts.sum(axis=1))
    return png_bytes(figure)


def _shades(rows: list[str], columns: list[str], shares: np.ndarray) -> np.ndarray:
    """Return colours, shape (rows, columns, 3): green right, red wrong, grey silent."""
    strong = {RIGHT: (0.10, 0.50, 0.29), WRONG: (0.75, 0.22, 0.17), UNKNOWN: (0.35, 0.42, 0.52)}
    colours = np.empty((*shares.shape, 3))
    for i, row in enumerate(rows):
        for j, column in enumerate(columns):
            kind = WRONG
            if column in (row, SET_WITH, BROKEN):
                kind = RIGHT
            elif column in (UNKNOWN, NONE):
                kind = RIGHT if row == "nothing" and column == NONE else UNKNOWN
            depth = 0.25 + 0.75 * shares[i, j] if shares[i, j] else 0.0
            colours[i, j] = 1.0 - depth * (1.0 - np.array(strong[kind]))
    return colours


def _label(axes: Axes, rows: list[str], columns: list[str], totals: np.ndarray) -> None:
    axes.set_xticks(range(len(columns)), [c.replace("_", " ") for c in columns], rotation=90)
    axes.set_yticks(
        range(len(rows)),
        [f"{r.replace('_', ' ')}  ({n})" for r, n in zip(rows, totals, strict=True)],
    )
    axes.xaxis.set_ticks_position("top")
    axes.xaxis.set_label_position("top")
    axes.set_xlabel("answer (a first name, or none)", fontsize=12)
    axes.set_ylabel("hidden (cases)", fontsize=12)
    effects = len(_effects())
    for place in (effects, effects + 4, effects + 5):
        axes.axvline(place - 0.5, color="#333", linewidth=1.0)
    for place in (effects, effects + 1, len(rows) - 1):
        axes.axhline(place - 0.5, color="#333", linewidth=1.0)
    axes.set_xticks(np.arange(len(columns) + 1) - 0.5, minor=True)
    axes.set_yticks(np.arange(len(rows) + 1) - 0.5, minor=True)
    axes.grid(which="minor", color="#e6e9ed", linewidth=0.6)
    axes.tick_params(which="both", length=0)
    axes.spines[:].set_visible(False)


def naming_by_size(records: Sequence[Record]) -> bytes:
    """Return the shares of each outcome against the gap that an effect leaves, as a PNG."""
    figure = Figure(figsize=(11.0, 4.6), layout="constrained")
    FigureCanvasAgg(figure)
    left, right = figure.subplots(1, 2, sharey=True)
    _bars(left, [r for r in records if r.kind == "effect"], OUTCOMES)
    left.set_title("One effect of the catalogue is missing", fontsize=11, loc="left")
    left.set_ylabel("share of the cases [%]")
    _bars(right, [r for r in records if r.kind in ("deleted", "outside")], OPEN_OUTCOMES)
    right.set_title("What is missing is in no catalogue", fontsize=11, loc="left")
    for axes in (left, right):
        axes.set_xlabel("gap over that of nothing hidden (cases)")
        axes.spines[["top", "right"]].set_visible(False)
        axes.legend(
            loc="upper center", bbox_to_anchor=(0.5, -0.2), ncols=3, frameon=False, fontsize=8.5
        )
    return png_bytes(figure)


def _bars(axes: Axes, records: Sequence[Record], outcomes: Sequence[str]) -> None:
    bins = [[r for r in records if low <= r.ratio < high] for low, high in pairwise(EDGES)]
    counts = np.array([list(tally([r.outcome for r in some], outcomes).values()) for some in bins])
    shares = 100.0 * counts / np.maximum(counts.sum(axis=1, keepdims=True), 1)
    bottom = np.zeros(len(bins))
    for j, name in enumerate(outcomes):
        axes.bar(
            range(len(bins)),
            shares[:, j],
            bottom=bottom,
            color=COLOURS[name],
            label="falsely named" if name == NAMED else name,
            width=0.86,
        )
        bottom += shares[:, j]
    names = [
        f"under {EDGES[1]:g}" if not low else f"{low:g}+" if high == np.inf else f"{low:g}–{high:g}"
        for low, high in pairwise(EDGES)
    ]
    axes.set_xticks(
        range(len(bins)),
        [f"{n}\n({len(some)})" for n, some in zip(names, bins, strict=True)],
        fontsize=8.5,
    )
    axes.set_ylim(0.0, 100.0)
