"""Reads text tables of any origin: encoding, separator, decimal mark, cells."""

from __future__ import annotations

import csv
import io
import re
from collections import Counter
from collections.abc import Iterable, Sequence
from pathlib import Path

from measurement.errors import BadInput, shown

SEPARATORS = (";", "\t", "|", ",")
"""In this order: a comma may also be a decimal mark."""
ONE_COLUMN = "\0"
"""Separator of a table with one column: a character that no text contains."""
_ONE_NUMBER = re.compile(r"\s*[+-]? *\d+(?:[.,]\d*)?(?:[eE][+-]?\d+)?\s*")
_APART = "' \u00a0\u202f\u2009\u2019"
_GROUPS = {
    decimal: rf"[1-9]\d{{0,2}}(?P<{name}>[{other}{_APART}])\d{{3}}(?:(?P={name})\d{{3}})*"
    rf"(?:{re.escape(decimal)}\d*)?"
    for decimal, other, name in ((".", ",", "comma"), (",", ".", "point"))
}
GROUPED = {mark: re.compile(rf"[+-]? *{groups}") for mark, groups in _GROUPS.items()}
"""By decimal mark: numbers with thousands separators."""
NUMBER = re.compile(
    rf"\s*[+-]? *(?:(?:\d+[.,]?\d*|[.,]\d+)(?:[eE][+-]?\d+)?|{_GROUPS['.']}|{_GROUPS[',']})\s*"
)
"""Numbers with either decimal mark."""


def decoded(data: bytes, path: Path) -> str:
    """Return a file's text: UTF-8 or UTF-16 with a mark, UTF-8, or else Windows' Latin-1.

    Raises
    ------
    BadInput
        If it is not text, or empty.
    """
    if data.startswith((b"\xff\xfe", b"\xfe\xff")):
        text = data.decode("utf-16", "replace")
    else:
        try:
            text = data.decode("utf-8-sig")
        except UnicodeDecodeError:
            text = data.decode("cp1252", "replace")
    if "\0" in text:
        raise BadInput(path, "", "is no text and no workbook or log of a kind that can be read")
    text = (
        text.replace("\N{MINUS SIGN}", "-").replace("\r\n", "\n").replace("\r", "\n").rstrip("\n ")
    )
    if not text.strip():
        raise BadInput(path, "", "is empty; a header and data rows are needed")
    return text


def separator_of(text: str, path: Path) -> str:
    """Return the separator of the cells.

    Raises
    ------
    BadInput
        If no separator divides most lines into equally many cells.
    """
    lines = [line for line in text.split("\n") if line.strip()]
    said = re.match(r"sep=(.)$", lines[0])
    if said:
        return said[1]
    body = lines[-max(2, len(lines) * 3 // 4) :]
    # A comma that occurs in the numbers but not in the header is a decimal mark.
    if all(_ONE_NUMBER.fullmatch(line) for line in body) and not re.search("[;\t|,]", lines[0]):
        return ONE_COLUMN
    bare = [re.sub('"[^"]*"', "", line) for line in body]
    for mark in SEPARATORS:
        counts = Counter(line.count(mark) for line in bare)
        count, often = counts.most_common(1)[0]
        if count and often >= 0.8 * sum(counts.values()):
            return mark
    marks = "semicolons, tabs, bars or commas"
    raise BadInput(path, "", f"holds no table: {marks} must stand between the columns of every row")


def cells_of(text: str, path: Path) -> list[list[str]]:
    """Return the cells of every line; a line without any cell is an empty list.

    Raises
    ------
    BadInput
        For a line that is not a row of a text table.
    """
    mark = separator_of(text, path)
    if '"' not in text:
        rows = [line.split(mark) if line.strip() else [] for line in text.split("\n")]
    else:
        rows = []
        try:
            for row in csv.reader(io.StringIO(text), delimiter=mark, strict=True):
                rows.append(row)
        except csv.Error as error:
            raise BadInput(path, f"row {len(rows) + 1}", f"cannot be read: {error}") from None
    if rows and len(rows[0]) <= 2 and re.match(r"sep=", text):
        rows[0] = []
    return rows


def decimal_mark(columns: Iterable[Sequence[str]], path: Path) -> str:
    """Return the decimal mark of a table's numbers.

    If 6,000 may be six or six thousand, other numbers decide: 0,125 and 20,5 contain a decimal
    mark, and so does 1.250,5. Without any, the mark separates thousands if smaller numbers have
    none, as in 0 and 6,000.

    Parameters
    ----------
    columns : iterable of sequence of str
        Cells of each column.
    path : Path

    Raises
    ------
    BadInput
        If both marks occur and the numbers are ambiguous.
    """
    sure: dict[str, str] = {}
    apart: dict[str, str] = {}
    either: dict[str, str] = {}
    for cells in columns:
        numbers = [cell.strip() for cell in cells if NUMBER.fullmatch(cell)]
        whole = [cell.lstrip("+- ") for cell in numbers if not re.search("[.,]", cell)]
        longest = max(map(len, whole), default=0)
        for cell in numbers:
            marks = [mark for mark in ",." if mark in cell]
            grouped = [mark for mark in ",." if GROUPED[mark].fullmatch(cell)]
            if marks and (not grouped or len(marks) == 2 or longest > 3):
                sure.setdefault(max(marks, key=cell.rindex), cell)
            elif marks and (whole or cell.count(marks[0]) > 1):
                apart.setdefault(grouped[0], cell)
            elif marks:
                either.setdefault(marks[0], cell)
    candidates = sure or apart or either or {".": ""}
    if len(candidates) == 2:
        commas, points = shown(candidates[","]), shown(candidates["."])
        problem = f"both {commas} and {points} stand in it: one decimal mark is needed"
        raise BadInput(path, "", problem)
    return next(iter(candidates))
