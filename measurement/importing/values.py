"""Cells of a column as numbers."""

from __future__ import annotations

import datetime as dt
import math
import re
from collections.abc import Callable, Sequence
from typing import TypeVar

import numpy as np

from measurement.errors import BadInput, shown
from measurement.importing.cells import Cell, Sheet, is_infinite, is_missing
from measurement.importing.text_tables import GROUPED, NUMBER
from measurement.resampling import FloatArray

C = TypeVar("C")
_FLAGS = {"on": 1.0, "off": 0.0, "true": 1.0, "false": 0.0, "ein": 1.0, "aus": 0.0, "yes": 1.0}
_FLAGS |= {"no": 0.0, "wahr": 1.0, "falsch": 0.0, "ja": 1.0, "nein": 0.0}
_POINT = {".": {}, ",": str.maketrans(",.", ".,")}
"""By decimal mark, the translation of a number for Python; the other mark is refused."""


def numbers_of(sheet: Sheet, at: int) -> FloatArray:
    """Return a column's numbers, shape (rows,); NaN where there is no value.

    Raises
    ------
    BadInput
        For the first cell that is neither a number nor a usual mark of a missing value.
    """
    plain = _plain(sheet.columns[at], sheet.decimal)
    if plain is not None:
        return plain
    return read_cells(sheet, at, sheet.columns[at], lambda cell: number_of(cell, sheet), "number")


def read_cells(
    sheet: Sheet, at: int, cells: Sequence[C], read: Callable[[C], float | None], kind: str
) -> FloatArray:
    """Return *read* applied to the cells of a column, shape (rows,); None refuses a cell.

    Raises
    ------
    BadInput
        For the first refused cell, which is not of that *kind*.
    """
    values = np.full(len(sheet.rows), np.nan)
    for row, cell in enumerate(cells):
        value = read(cell)
        if value is None:
            place = f"row {sheet.rows[row]}, column {sheet.headings[at].text}"
            raise BadInput(sheet.where, place, f"{shown(cell)} is not a {kind}")
        values[row] = value
    return values


def _plain(cells: list[Cell], decimal: str) -> FloatArray | None:
    """Return numbers as Python reads them, which is fast; None if a cell needs `number_of`."""
    if decimal != "." and any(isinstance(cell, str) for cell in cells):
        return None
    try:
        values = np.array([float(cell) for cell in cells])  # type: ignore[arg-type]
    except (TypeError, ValueError, OverflowError):
        return None
    odd = any("_" in cell for cell in cells if isinstance(cell, str))
    return None if odd or not np.isfinite(values).all() else values


def number_of(cell: Cell, sheet: Sheet) -> float | None:
    """Return a cell's number; NaN if it marks a missing value, None if it is something else.

    A flag (on, off, true, false) is 1 or 0.
    """
    if cell is None:
        return float("nan")
    if isinstance(cell, (dt.date, dt.time, dt.timedelta)):
        return None
    if not isinstance(cell, str):
        return float(cell)
    if is_infinite(cell):
        return -math.inf if "-" in cell else math.inf
    if is_missing(cell):
        return float("nan")
    text = cell.strip()
    if (flag := _FLAGS.get(text.casefold())) is not None:
        return flag
    if not NUMBER.fullmatch(text):
        return None
    if GROUPED[sheet.decimal].fullmatch(text):
        text = re.sub(rf"[^\d{sheet.decimal}+-]", "", text)
    try:
        return float(text.replace(" ", "").translate(_POINT[sheet.decimal]))
    except ValueError:
        return None


def is_numeric(sheet: Sheet, at: int) -> bool:
    """Return whether a column looks like numbers in its first rows."""
    some = [number_of(cell, sheet) for cell in sheet.columns[at][:50]]
    return None not in some and any(math.isfinite(value) for value in some if value is not None)
