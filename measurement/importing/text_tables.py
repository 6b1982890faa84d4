"""Text tables: encoding, separator, decimal mark, and cells, whatever wrote them."""

from __future__ import annotations

import csv
import io
import re
from collections import Counter
from pathlib import Path

from measurement.errors import BadInput, shown

SEPARATORS = (";", "\t", "|", ",")
"""In this order: a comma may also be a decimal mark."""
ONE_COLUMN = "\0"
"""What separates the cells of one column: nothing that a text holds."""
HEAD_LINES = 400
"""Among so many lines the header and the separator are looked for: set on no data."""
_DECIMAL_COMMA = re.compile(r"\s*[+-]? *\d+,\d+(?:[eE][+-]?\d+)?\s*")
_DECIMAL_POINT = re.compile(r"\s*[+-]? *\d*\.\d+(?:[eE][+-]?\d+)?\s*")
_ONE_NUMBER = re.compile(r"\s*[+-]? *\d+(?:[.,]\d*)?(?:[eE][+-]?\d+)?\s*")
_THOUSANDS = re.compile(r"\s*[+-]? *\d{1,3}(?:\.\d{3})+,\d+\s*")
_GROUPED = re.compile(r"\s*[+-]? *\d{1,3}(?:\.\d{3})+\s*")


def decoded(data: bytes, path: Path) -> str:
    """Return a file's text: UTF-8 or UTF-16 with a mark, UTF-8, or else Windows' Latin-1.

    Raises
    ------
    BadInput
        If it is no text, or empty.
    """
    if data.startswith((b"\xff\xfe", b"\xfe\xff")):
        text = data.decode("utf-16", "replace")
    else:
        try:
            text = data.decode("utf-8-sig")
        except UnicodeDecodeError:
            text = data.decode("cp1252", "replace")
    if "\0" in text:
        problem = "is no text and no workbook or log of a kind that can be read"
        raise BadInput(path, "", problem)
    text = text.replace("\r\n", "\n").replace("\r", "\n").rstrip("\n ")
    if not text.strip():
        raise BadInput(path, "", "is empty; a header and data rows are needed")
    return text


def separator_of(text: str, path: Path) -> str:
    """Return what stands between the cells.

    Raises
    ------
    BadInput
        If no separator divides most lines into equally many cells.
    """
    lines = [line for line in text.split("\n")[:HEAD_LINES] if line.strip()]
    said = re.match(r"sep=(.)$", lines[0])
    if said:
        return said[1]
    body = lines[-max(2, len(lines) * 3 // 4) :]
    # A decimal comma that no header shares divides nothing.
    if all(_ONE_NUMBER.fullmatch(line) for line in body) and not re.search("[;\t|,]", lines[0]):
        return ONE_COLUMN
    for mark in SEPARATORS:
        counts = Counter(line.count(mark) for line in body)
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


def decimal_mark(rows: list[list[str]], path: Path) -> tuple[str, str]:
    """Return the decimal mark and the mark of thousands, which is mostly empty.

    Raises
    ------
    BadInput
        If both marks stand in numbers that cannot be told apart.
    """
    cells = [cell for row in rows[:HEAD_LINES] for cell in row]
    thousands = next((cell for cell in cells if _THOUSANDS.fullmatch(cell)), None)
    if thousands:
        cells = [cell for cell in cells if not _GROUPED.fullmatch(cell)]
    commas = thousands or next((cell for cell in cells if _DECIMAL_COMMA.fullmatch(cell)), None)
    points = next((cell for cell in cells if _DECIMAL_POINT.fullmatch(cell)), None)
    if commas and points:
        problem = (
            f"both {shown(commas)} and {shown(points)} stand in it: one decimal mark is needed"
        )
        raise BadInput(path, "", problem)
    return ("," if commas else "."), ("." if thousands else "")
