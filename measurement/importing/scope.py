"""Exports of TwinCAT's Scope View, with a clock before each channel or each sampling time's group.

The lines above the numbers describe the channels. Each has its key above every clock, followed by
the values: ``Name, T1, Name, T2`` and ``Unit, °C (Temperature), Unit, (None)``. Clocks count
milliseconds from the start of the export or, as full time stamps, 100 ns from 1601.
"""

from __future__ import annotations

from itertools import zip_longest

START, NAME, UNIT = "Starttime of export", "Name", "Unit"


def with_plain_header(rows: list[list[str]]) -> list[list[str]]:
    """Return a text table's rows; those of such an export with a single line of names and units."""
    labels = [row[0] if len(row) > 1 else "" for row in rows]
    begun = labels.index(START) if START in labels else len(labels)
    if NAME not in labels[begun:]:
        return rows
    first = labels.index(NAME, begun)
    end = labels.index("", first) if "" in labels[first:] else len(rows)
    units = next((row for row in rows[first:end] if row[0] == UNIT), [])
    number = next((row[0] for row in rows[end:] if row), "")
    # A full time stamp has as many digits as the export's start time.
    clock = "Time" if len(number) == len(rows[begun][1]) else "Time [ms]"
    said = (unit.partition("(")[0].strip() for unit in units)
    header = [
        clock if name == NAME else f"{name} [{unit}]" if unit else name
        for name, unit in zip_longest(rows[first], said, fillvalue="")
    ]
    return [*rows[:first], header, *([] for _ in rows[first + 1 : end]), *rows[end:]]
