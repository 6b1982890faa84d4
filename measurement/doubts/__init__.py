"""Finds runs whose numbers contradict a unit, the clock's unit, a sign, a thermometer's place.

Each doubt compares the likelihood of the numbers as declared with that under one of the usual
mistakes. `readings` checks units, `places` swapped thermometers, `signs` displacements with the
opposite sign, `clock` an hour that is missing. Nothing is changed.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import NamedTuple

from measurement.doubts.clock import put_forward
from measurement.doubts.places import swapped
from measurement.doubts.readings import unlikely_units
from measurement.doubts.signs import doubted_signs
from measurement.doubts.warming import warming
from measurement.runs import Run


class Doubt(NamedTuple):
    """What looks wrong in a column, and how to correct it."""

    column: str
    text: str


def doubts(runs: Sequence[Run]) -> list[Doubt]:
    """Return what looks wrong in runs of one machine, one entry per column and kind."""
    if not runs:
        return []
    warm = [warming(run) for run in runs]
    units, signs = unlikely_units(runs, warm), doubted_signs(runs, warm)
    pairs = [*units, *put_forward(runs), *swapped(runs), *signs]
    return [Doubt(column, text) for column, text in pairs]


def doubt_lines(runs: Sequence[Run]) -> list[str]:
    """Return the doubts as lines for a terminal, a report or a compensator file."""
    return [f"doubtful: {doubt.column} {doubt.text}" for doubt in together(doubts(runs))]


def together(doubts: Sequence[Doubt]) -> list[Doubt]:
    """Return doubts as given, those whose texts differ only in numbers merged into one."""
    alike: dict[str, list[Doubt]] = {}
    for doubt in doubts:
        alike.setdefault(re.sub(r"\b\d[\d.]*\b", "", doubt.text), []).append(doubt)
    return [
        Doubt(first.column, f"{first.text}; so is {', '.join(other.column for other in others)}")
        if others
        else first
        for first, *others in alike.values()
    ]


__all__ = ["Doubt", "doubt_lines", "doubts", "together"]
