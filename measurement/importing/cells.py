"""A table as in the file: headings, and a column of cells for each, not yet interpreted."""

from __future__ import annotations

import datetime as dt
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from measurement.importing.headers import Heading

Cell = str | float | int | bool | dt.date | dt.time | dt.timedelta | None
MISSING = frozenset(
    word.casefold()
    for word in (
        *("", "NaN", "NA", "N/A", "null", "None", "OL", "overload", "over", "under", "overflow"),
        *("err", "error", "NV", "WERT", "VALUE", "DIV/0", "REF", "burnout", "1.#QNAN"),
        "1.#IND",
    )
)
"""What recorders write for a missing value, in lower case, without enclosing signs."""
INFINITE = frozenset({"inf", "infinity", "1.#inf"})
"""What they write for a reading beyond all numbers, likewise."""


@dataclass(frozen=True)
class Sheet:
    """A table as in the file.

    Attributes
    ----------
    path : Path
    title : str
        Title of a workbook's sheet or a log's group; empty for a text table.
    headings : tuple of Heading
    columns : list of list
        Cells of each column, as text, number or time.
    rows : list of int
        Number of each row in the file, from 1.
    decimal : str
        Decimal mark of numbers that are text.
    notes : tuple of str
        What was ignored.
    """

    path: Path
    title: str
    headings: tuple[Heading, ...]
    columns: list[list[Cell]]
    rows: list[int]
    decimal: str = "."
    notes: tuple[str, ...] = ()

    @property
    def where(self) -> str:
        """Name of the table in messages."""
        return f"{self.path}, {self.title}" if self.title else str(self.path)

    def turned(self) -> Sheet:
        """Return the sheet with its rows in the reverse order."""
        return replace(self, columns=[each[::-1] for each in self.columns], rows=self.rows[::-1])

    def part(self, name: str, columns: Sequence[int], rows: Sequence[int], *, first: bool) -> Sheet:
        """Return some columns and rows, by index, as a sheet; the first part keeps the notes."""
        return replace(
            self,
            title=f"{self.title}, {name}" if self.title else name,
            headings=tuple(self.headings[at] for at in columns),
            columns=[[self.columns[at][row] for row in rows] for at in columns],
            rows=[self.rows[row] for row in rows],
            notes=self.notes if first else (),
        )


def is_missing(cell: Cell) -> bool:
    """Return whether a cell marks a missing value, or one beyond all numbers."""
    return cell is None or (isinstance(cell, str) and _bare(cell) in MISSING | INFINITE)


def is_infinite(cell: str) -> bool:
    """Return whether a cell is a reading beyond all numbers."""
    return _bare(cell) in INFINITE


def _bare(cell: str) -> str:
    return cell.strip("+-*?#! \t").casefold()
