"""What runs contradict: a unit, the clock's unit, a sign, the place of a thermometer.

Every doubt is one comparison: how likely are the numbers as they were said to be, and how likely if
they were said wrongly in one of the usual ways? `readings` compares units, `places` thermometers
that were swapped, `signs` displacements that were turned round. Nothing is changed.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import NamedTuple

from measurement.doubts.places import swapped
from measurement.doubts.readings import unlikely_units
from measurement.doubts.signs import doubted_signs
from measurement.doubts.warming import warming
from measurement.runs import Run


class Doubt(NamedTuple):
    """What looks wrong with a column, and what would set it right."""

    column: str
    text: str


def doubts(runs: Sequence[Run]) -> list[Doubt]:
    """Return what looks wrong with runs of one machine, one entry for each column and kind."""
    if not runs:
        return []
    warm = [warming(run) for run in runs]
    found = [*unlikely_units(runs, warm), *swapped(runs), *doubted_signs(runs, warm)]
    return [Doubt(column, text) for column, text in found]


def doubt_lines(runs: Sequence[Run]) -> list[str]:
    """Return the doubts as lines for a terminal, a report or a compensator file."""
    return [f"doubtful: {doubt.column} {doubt.text}" for doubt in together(doubts(runs))]


def together(found: Sequence[Doubt]) -> list[Doubt]:
    """Return one doubt for columns that are doubted alike, but for numbers."""
    alike: dict[str, list[Doubt]] = {}
    for doubt in found:
        alike.setdefault(re.sub(r"\b\d[\d.]*\b", "", doubt.text), []).append(doubt)
    return [
        Doubt(first.column, f"{first.text}; so is {', '.join(other.column for other in others)}")
        if others
        else first
        for first, *others in alike.values()
    ]


__all__ = ["Doubt", "doubt_lines", "doubts", "together"]
