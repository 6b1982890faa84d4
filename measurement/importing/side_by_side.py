"""Splits blocks of columns side by side, each with its own clock, into separate tables."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise

from measurement.importing.cells import Sheet, is_missing
from measurement.importing.quantities import conversion_of
from measurement.importing.stamps import is_date, seconds_of_day
from measurement.importing.values import is_numeric

_NUMBERED = re.compile(r"[\s_.]*\d+$")


def by_clock(sheet: Sheet, clocks: Sequence[str] = ()) -> list[Sheet]:
    """Return a sheet for each block of columns that begins with a clock; usually one.

    A further clock is of the same kind as the first (dates, times of day, or numbers named as
    time), with other columns before and after it.

    Parameters
    ----------
    sheet : Sheet
    clocks : sequence of str
        Headers of clocks, whatever their names.
    """
    kinds = [_kind(sheet, at, clocks) for at in range(len(sheet.headings))]
    first = next((at for at, kind in enumerate(kinds) if kind), 0)
    begins = [
        at
        for at in range(first + 1, len(kinds))
        if kinds[at] == kinds[first] != "" == kinds[at - 1] and "" in kinds[at:]
    ]
    edges = [0, *begins, len(kinds)]
    return [_block(sheet, *ends) for ends in pairwise(edges)] if begins else [sheet]


def _kind(sheet: Sheet, at: int, clocks: Sequence[str]) -> str:
    """Return the kind of clock in a column; empty if it is not a clock."""
    entry = sheet.headings[at]
    some = [cell for cell in sheet.columns[at][:20] if not is_missing(cell)]
    if len(set(map(str, some))) > 1 and all(map(is_date, some)):
        return "dates"
    if some and all(seconds_of_day(cell) is not None for cell in some):
        return "times of day"
    plain = replace(entry, name=_NUMBERED.sub("", entry.name))
    unit = conversion_of(entry.unit) if entry.unit else None
    # T and T2 are temperatures unless they have a unit of time.
    counts = unit.suffix == "s" if unit else not entry.said and len(plain.name) > 1
    called = entry.text in clocks or (plain.is_time and counts)
    return "numbers" if called and is_numeric(sheet, at) else ""


def _block(sheet: Sheet, start: int, end: int) -> Sheet:
    """Return some columns of a sheet, without rows in which they are empty."""
    rows = enumerate(zip(*sheet.columns[start:end], strict=True))
    filled = [row for row, cells in rows if not all(map(is_missing, cells))]
    return sheet.part(f"columns {start + 1} to {end}", range(start, end), filled, first=not start)
