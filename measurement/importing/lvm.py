"""Reads LabVIEW measurement files (``.lvm``): a header for the file, and one per segment."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from measurement.errors import BadInput
from measurement.importing.cells import Cell, Sheet
from measurement.importing.logs import Channel, clock, sheet_of
from measurement.importing.stamps import SINCE_1904_S, seconds_of_date

BEGIN = "LabVIEW Measurement"
END = re.compile(r"^\*\*\*End_of_Header\*\*\*.*\n", re.MULTILINE)
CLOCK_NAME, COMMENT = "X_Value", "Comment"
Facts = dict[str, list[str]]


def read_lvm(path: Path, text: str) -> list[Sheet]:
    """Read the channels of all segments; channels with their own clock are a sheet.

    Parameters
    ----------
    path : Path
    text : str
        The file's text, which begins with `BEGIN`.

    Raises
    ------
    BadInput
        If a header does not end, or a row does not fit it.
    """
    head, *rest = END.split(text)
    mark = "," if "Separator,Comma" in head else "\t"
    file_facts = _facts(head, mark)
    if len(rest) < 2:
        raise BadInput(path, "", "holds no segment with a header and rows")
    sheets: list[Sheet] = []
    heading = rest[0]
    for number, block in enumerate(rest[1:], 1):
        title = f"segment {number}"
        body, _, following = block.partition("\nChannels" + mark)
        try:
            sheets += _segment(path, title, body, file_facts | _facts(heading, mark), mark)
        except ValueError as error:
            raise BadInput(path, title, f"its clock cannot be read: {error}") from None
        heading = "Channels" + mark + following
    return sheets


def _facts(head: str, mark: str) -> Facts:
    cells = [[cell.strip() for cell in line.split(mark)] for line in head.split("\n")]
    return {key: values for key, *values in cells if key}


def _segment(path: Path, title: str, body: str, facts: Facts, mark: str) -> Iterator[Sheet]:
    names, *lines = [line.split(mark) for line in body.split("\n") if line.strip()] or [[]]
    if not lines:
        return
    decimal = facts.get("Decimal_Separator", ["."])[0]
    columns: list[list[Cell]] = [[] for _ in names]
    for row in lines:
        if len(row) > len(names):
            raise BadInput(path, title, f"a row has {len(row)} cells, its header {len(names)}")
        for at, column in enumerate(columns):
            cell = row[at].strip().replace(decimal, ".") if at < len(row) else ""
            column.append(cell or None)
    start = facts.get("Date", [""])[0].replace("/", "-")
    zero = seconds_of_date(f"{start} {facts.get('Time', [''])[0].replace(decimal, '.')}", True)
    if facts.get("Time_Pref", [""])[0] == "Absolute":
        zero = -SINCE_1904_S
    by_clock: dict[bytes, list[Channel]] = {}
    rows, channel = list(range(len(lines))), 0
    times = np.arange(len(lines), dtype=np.float64)
    for name, cells in zip(names, columns, strict=True):
        if name.strip() == CLOCK_NAME:
            filled = [at for at, cell in enumerate(cells) if cell is not None]
            # Channels may end early; a time missing before that is refused as usual.
            rows = list(range(filled[-1] + 1 if filled else len(lines)))
            step = float(_of(facts, "Delta_X", channel, "1").replace(decimal, "."))
            first = float(_of(facts, "X0", channel, "0").replace(decimal, "."))
            counted = [at * step + first for at in rows]
            shown = [np.nan if cells[at] is None else cells[at] for at in rows]
            times = np.array(shown if filled else counted, dtype=np.float64)
            continue
        if name.strip() == COMMENT:
            continue
        unit = _of(facts, "Y_Unit_Label", channel, "")
        channel += 1
        held = by_clock.setdefault(times.tobytes(), [clock(times + (zero or 0.0))])
        held.append((name.strip(), unit, [cells[at] for at in rows]))
    for number, held in enumerate(by_clock.values(), 1):
        yield sheet_of(path, title if len(by_clock) == 1 else f"{title}.{number}", held)


def _of(facts: Facts, key: str, channel: int, otherwise: str) -> str:
    values = facts.get(key, [])
    return values[channel] if channel < len(values) and values[channel] else otherwise
