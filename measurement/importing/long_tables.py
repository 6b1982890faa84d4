"""Tables with one row per value, as historians export them: time, signal name, value."""

from __future__ import annotations

import re
from dataclasses import replace

from measurement.errors import BadInput
from measurement.importing.cells import Sheet, is_missing
from measurement.importing.headers import headings

_NAME = re.compile(
    r"tag|tag[ _]?name|name|channel|signal|variable|sensor|point|item|kanal|messstelle|parameter"
    r"|metric|field|series|quantity",
    re.IGNORECASE,
)
_VALUE = re.compile(r"_?value|wert|messwert|reading", re.IGNORECASE)
_UNIT = re.compile(r"units?|einheit|eng(ineering)?[ _]?units?", re.IGNORECASE)


def by_signal(sheet: Sheet) -> list[Sheet]:
    """Return a sheet for each signal of a table with one row per value; other tables unchanged.

    Parameters
    ----------
    sheet : Sheet

    Raises
    ------
    BadInput
        For a value without a signal name.
    """
    names = [entry.name.strip() for entry in sheet.headings]
    signals = [at for at, name in enumerate(names) if _NAME.fullmatch(name)]
    values = [at for at, name in enumerate(names) if _VALUE.fullmatch(name)]
    units = [at for at, name in enumerate(names) if _UNIT.fullmatch(name)]
    clock = [at for at, entry in enumerate(sheet.headings) if entry.is_time]
    if len(signals) != 1 or len(values) != 1 or not clock:
        return [sheet]
    rows: dict[str, list[int]] = {}
    for row, name in enumerate(sheet.columns[signals[0]]):
        if is_missing(name):
            place = f"row {sheet.rows[row]}, column {sheet.headings[signals[0]].text}"
            raise BadInput(
                sheet.where, place, "is missing; every value needs the name of its signal"
            )
        rows.setdefault(str(name).strip(), []).append(row)
    said = [str(sheet.columns[units[0]][kept[0]] or "") if units else "" for kept in rows.values()]
    named = headings(list(rows), [unit or sheet.headings[values[0]].unit for unit in said])
    sheets: list[Sheet] = []
    for (name, kept), value in zip(rows.items(), named, strict=True):
        part = sheet.part(name, (*clock, values[0]), kept, first=not sheets)
        sheets.append(replace(part, headings=(*part.headings[:-1], value)))
    return sheets
