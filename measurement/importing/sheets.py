"""Reads a file as sheets: finds where its tables begin and end, and their headers."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Sequence
from dataclasses import replace
from itertools import zip_longest
from pathlib import Path
from typing import Any

from python_calamine import CalamineWorkbook, SheetVisibleEnum

from measurement.errors import BadInput, counted
from measurement.files import read_bytes
from measurement.importing.cells import Cell, Sheet, is_missing
from measurement.importing.headers import Heading, headings, is_unit_line
from measurement.importing.json_rows import is_json, read_json
from measurement.importing.logs import read_log
from measurement.importing.long_tables import by_signal
from measurement.importing.lvm import BEGIN, read_lvm
from measurement.importing.plugged import EXCEL, LOGS, read_plugged
from measurement.importing.quantities import Conversion, conversion_of
from measurement.importing.scope import with_plain_header
from measurement.importing.text_tables import NUMBER, cells_of, decimal_mark, decoded

CLOCK = re.compile(
    r"\s*\d{1,4}(?:[-./:]\d{1,2}\b|[-./ ]+[A-Za-zä]{3,9}[-./ ,]+\d{2}).*|\s*\d+ ?d \d+:\d+.*"
)


def read_sheets(path: Path) -> list[Sheet]:
    """Read all tables of a file.

    Parameters
    ----------
    path : Path
        A text table; or, by its extension, a workbook (``.xlsx``, ``.xls``, ...), a log (``.tdms``,
        ``.mf4``, ``.mdf``, ``.dat`` if it is one), or a file that a plug-in reads.

    Raises
    ------
    BadInput
        If it has no table, or cannot be read.
    """
    ending = path.suffix.lower()
    data = read_bytes(path)
    if (plugged := read_plugged(path)) is not None:
        sheets = plugged
    elif ending in EXCEL:
        sheets = _workbook(path)
    elif ending in LOGS or data[:8].startswith(b"MDF     "):
        sheets = read_log(path)
    else:
        text = decoded(data, path)
        if text.startswith(BEGIN):
            sheets = read_lvm(path, text)
        elif is_json(text):
            sheets = read_json(path, text)
        else:
            rows: list[list[Cell]] = [list(row) for row in with_plain_header(cells_of(text, path))]
            sheets = [_sheet(path, "", rows)]
    if not sheets:
        raise BadInput(path, "", "holds no table with a header and data rows")
    return [part for sheet in sheets for part in by_signal(sheet)]


def _workbook(path: Path) -> list[Sheet]:
    try:
        with CalamineWorkbook.from_path(str(path)) as book:
            visible = {
                sheet.name: sheet.visible == SheetVisibleEnum.Visible
                for sheet in book.sheets_metadata
            }
            shown = [(name, book.get_sheet_by_name(name)) for name in visible if visible[name]]
            tables = [
                (name, _unmerged(sheet.to_python(skip_empty_area=False), sheet.merged_cell_ranges))
                for name, sheet in shown
            ]
    except Exception as error:  # the library's errors for each format have no common base
        raise BadInput(path, "", f"is no workbook that can be read: {error}") from None
    sheets: list[Sheet] = []
    left_out = [BadInput(path, name, "is hidden") for name, seen in visible.items() if not seen]
    for name, cells in tables:
        if sum(any(not is_missing(cell) for cell in row) for row in cells) < 2:
            continue  # an empty sheet, or a lone title
        try:
            sheets.append(_sheet(path, name, cells))
        except BadInput as error:
            # A workbook may contain a cover or figures, but must contain at least one table.
            left_out.append(error)
    if left_out and not sheets:
        raise left_out[0]
    if left_out:
        notes = [f"left out: {error.place or path.name}: {error.problem}" for error in left_out]
        sheets[0] = replace(sheets[0], notes=(*sheets[0].notes, *notes))
    return sheets


def _unmerged(
    rows: Sequence[Sequence[Cell]], ranges: Sequence[tuple[tuple[int, int], ...]] | None
) -> list[list[Cell]]:
    """Return a sheet's rows with the text of each merged cell in all cells that it covers, except
    one that is alone in its row: a title is no name of a column.
    """
    cells = [list(row) for row in rows]
    filled = [sum(not _is_blank(cell) for cell in row) for row in rows]
    for (top, left), (bottom, right) in ranges or ():
        text = cells[top][left] if top < len(cells) and left < len(cells[top]) else None
        if isinstance(text, str) and filled[top] > 1:
            for row in cells[top : bottom + 1]:
                row[left : right + 1] = [text] * len(row[left : right + 1])
    return cells


def _sheet(path: Path, title: str, rows: list[list[Cell]]) -> Sheet:
    """Find the header, and turn rows into columns.

    Raises
    ------
    BadInput
        If there is no header, or a row does not fit it.
    """
    place = f"{title}, " if title else ""
    fewest, usual = min(2, _usual_filled(rows)), _usual_length(rows[len(rows) // 2 :])
    numeric = _numeric_columns(rows)
    table = (i for i in range(1, len(rows)) if len(rows[i]) == usual)
    first = next((i for i in table if _is_data(rows[i], numeric, fewest)), None)
    if rows and _is_data(rows[0], numeric, fewest):
        raise BadInput(path, f"{place}row 1", "holds numbers; a header with names must stand first")
    if first is None:
        raise BadInput(path, title, "holds no table: no row of numbers")
    named, width, skipped = _headings(path, rows, first, place)
    above = max(i for i in range(first) if _filled(rows[i]))
    if _is_data(rows[above], numeric, fewest):
        raise _wrong_width(path, f"{place}row {above + 1}", len(rows[above]), usual)
    notes = [f"{counted(skipped, 'line')} before the header: skipped"] if skipped else []
    last = next(
        i
        for i in range(len(rows) - 1, first - 1, -1)
        if i == first or (_is_data(rows[i], numeric, 1) and not _is_summed_up(rows[i], numeric))
    )
    if after := sum(map(_filled, rows[last + 1 :])):
        notes.append(f"{counted(after, 'line')} after the last row of numbers: skipped")
    kept = [(i + 1, rows[i]) for i in range(first, last + 1) if _filled(rows[i])]
    heads = {str(rows[i][0]): rows[i] for i in range(first) if rows[i]}
    # A recorder that is resumed writes its header again.
    again = {number for number, row in kept if row == heads.get(str(row[0]))}
    if again:
        notes.append(f"{counted(len(again), 'line')} that repeat the header: skipped")
        kept = [entry for entry in kept if entry[0] not in again]
    _check_widths(path, place, kept, width, notes)
    numbers = [number for number, _ in kept]
    columns: list[list[Cell]] = [
        [row[at] if at < len(row) else None for _, row in kept] for at in range(width)
    ]
    for at, entry in enumerate(named):
        if not entry.text and not all(map(is_missing, columns[at])):
            raise _nameless(path, f"{place}row {first}, column {at + 1}", named)
    left = [at for at, entry in enumerate(named) if entry.text]
    texts = ([cell for cell in dict.fromkeys(cells) if isinstance(cell, str)] for cells in columns)
    return Sheet(
        path,
        title,
        tuple(named[at] for at in left),
        [columns[at] for at in left],
        numbers,
        decimal_mark(texts, path),
        tuple(notes),
    )


def _nameless(path: Path, place: str, headings: Sequence[Heading]) -> BadInput:
    problem = "has values but no name"
    if 2 * sum(bool(entry.text) for entry in headings) == len(headings):
        problem += ": decimal commas need another separator than a comma, such as a semicolon"
    return BadInput(path, place, problem)


def _headings(
    path: Path, rows: list[list[Cell]], first: int, place: str
) -> tuple[list[Heading], int, int]:
    """Return the headings, the table's width, and the number of lines before its header."""
    above = [i for i in range(first) if _filled(rows[i])]
    if not above:
        raise BadInput(path, f"{place}row {first + 1}", "no header with names stands above it")
    names, units, at = _names_and_units([_texts(rows[i]) for i in above], _usual_filled(rows))
    upper = _texts(rows[above[at - 1]]) if at and above[at - 1] == above[at] - 1 else []
    if len(upper) == len(names) == len(units):
        # A name that is merged over the line of units is no unit.
        units = ["" if unit == name else unit for name, unit in zip(names, units, strict=True)]
        alone, names = names, _below(upper, names, units)
        at -= names != alone
    usual = _usual_length(rows[first:])
    width = max(len(_trimmed(row)) for row in rows[first : first + 50] if len(row) == usual)
    width = max(width, *(len(texts) - _blank_end(texts) for texts in (names, units)))
    return headings(*(_padded(texts, width) for texts in (names, units))), width, at


def _below(upper: list[str], names: list[str], units: list[str]) -> list[str]:
    """Return the names of columns with what stands above them: alone where there is no name, and
    before one that occurs twice, or that has its unit from there.
    """
    count = Counter(names)
    found = []
    for over, name, unit in zip(headings(upper, [""] * len(upper)), names, units, strict=True):
        # A 1 in brackets is rather the first of several than a flag.
        given = "" if over.unit == "1" or headings([name], [unit])[0].unit else over.unit
        if not name or over.text in ("", name):
            found.append(name or over.text)
        elif given or count[name] > 1:
            found.append(f"{over.name} {name}" + (f" [{given}]" if given else ""))
        else:
            found.append(name)
    return found


def _names_and_units(lines: list[list[str]], filled: int) -> tuple[list[str], list[str], int]:
    """Return names and units, and the index of the names among the lines above the numbers.

    The last line has the names, or the units of the names above it. Comment lines may follow the
    units: they do if none of them names a time and the line above the units does.
    """
    last = len(lines) - 1
    plain = (lines[last], [""] * len(lines[last]), last)
    for at in range(last, max(0, last - 3), -1):
        if len(lines[at]) != len(lines[last]):
            break
        if is_unit_line(lines[at]) and sum(map(bool, lines[at - 1])) >= min(2, filled):
            stacked = (lines[at - 1], lines[at], at - 1)
            if at == last or (_names_a_time(*stacked[:2]) and not _names_a_time(*plain[:2])):
                return stacked
    return plain


def _padded(texts: list[str], width: int) -> list[str]:
    return (texts + [""] * width)[:width]


def _names_a_time(names: list[str], units: list[str]) -> bool:
    headers = headings(_padded(names, len(units)), units)
    kinds = [conversion_of(entry.unit) for entry in headers if entry.unit]
    return any(entry.is_time for entry in headers) or Conversion("s") in kinds


def _check_widths(
    path: Path,
    place: str,
    kept: list[tuple[int, list[Cell]]],
    width: int,
    notes: list[str],
) -> None:
    """Refuse a row wider or narrower than the others; the last one may be cut off."""
    usual = _usual_length([row for _, row in kept])
    for number, row in kept:
        if len(row) == usual or (len(row) > usual and len(_trimmed(row)) <= width):
            continue
        if number == kept[-1][0] and len(row) < usual:
            notes.append(f"the last row ({number}) is cut off and left out")
            kept.pop()
            return
        raise _wrong_width(path, f"{place}row {number}", len(row), usual)


def _wrong_width(path: Path, place: str, cells: int, usual: int) -> BadInput:
    return BadInput(path, place, f"has {cells} cells; the others have {usual}")


def _usual_length(rows: Sequence[Sequence[Cell]]) -> int:
    """Return the number of cells that most rows have, ignoring blank rows."""
    return Counter(len(row) for row in rows if _filled(row)).most_common(1)[0][0]


def _texts(row: Sequence[Cell]) -> list[str]:
    return ["" if cell is None else str(cell).strip() for cell in row]


def _trimmed(row: Sequence[Cell]) -> list[Cell]:
    cells = list(row)
    while cells and is_missing(cells[-1]):
        cells.pop()
    return cells


def _blank_end(texts: Sequence[str]) -> int:
    """Return the number of empty texts at the end."""
    return next((n for n, text in enumerate(reversed(texts)) if text), len(texts))


def _filled(row: Sequence[Cell]) -> bool:
    return any(not _is_blank(cell) for cell in row)


def _is_blank(cell: Cell) -> bool:
    return cell is None or (isinstance(cell, str) and not cell.strip())


def _usual_filled(rows: Sequence[Sequence[Cell]]) -> int:
    """Return the number of filled cells that most rows with any have; a table may be one column.

    Only the second half is used, to skip lines before the header.
    """
    later = [row for row in rows[len(rows) // 2 :] if _filled(row)]
    counts = Counter(sum(not _is_blank(cell) for cell in row) for row in later)
    return counts.most_common(1)[0][0] if counts else 0


def _numeric_columns(rows: Sequence[Sequence[Cell]]) -> set[int]:
    """Return the columns that hold numbers or times in most rows of the second half."""
    later = [row for row in rows[len(rows) // 2 :] if _filled(row)]
    numeric = set[int]()
    for at, cells in enumerate(zip_longest(*later)):
        said = {cell: count for cell, count in Counter(cells).items() if not is_missing(cell)}
        values = sum(count for cell, count in said.items() if _is_value(cell))
        if 2 * values > sum(said.values()):
            numeric.add(at)
    return numeric


def _is_data(row: Sequence[Cell], numeric: set[int], fewest: int) -> bool:
    """Return whether a row holds values: enough cells, and numbers or times in most columns that
    have them further down.
    """
    filled = [cell for cell in row if not _is_blank(cell)]
    said = [cell for at, cell in enumerate(row) if at in numeric and not is_missing(cell)]
    values = sum(_is_value(cell) for cell in said)
    return len(filled) >= fewest and 2 * values > len(said)


def _is_summed_up(row: Sequence[Cell], numeric: set[int]) -> bool:
    """Return whether a row is a mean or maximum of those above: it has a word in the column of
    their first number or time.
    """
    first = row[min(numeric)] if min(numeric) < len(row) else None
    return not is_missing(first) and not _is_value(first)


def _is_value(cell: Any) -> bool:
    if isinstance(cell, bool) or cell is None:
        return isinstance(cell, bool)
    if isinstance(cell, str):
        return bool(NUMBER.fullmatch(cell) or CLOCK.fullmatch(cell))
    return True
