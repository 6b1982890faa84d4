"""Logs as recorders write them, for the importer's tests."""

import datetime as dt
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

ROWS = 40
START = dt.datetime(2026, 3, 2, 7, 15)
HEADER = ("Temp. Lager vorn [°C]", "T hinten (degC)", "Halle [°C]", "Drehzahl [1/min]", "z [µm]")


def signals(rows: int = ROWS) -> np.ndarray:
    """Return five signals of a machine that warms up, shape (rows, 5)."""
    rise = 1.0 - np.exp(-np.arange(rows) / 20.0)
    speed = np.where(np.arange(rows) < 2, 0.0, 6000.0)
    columns = (21.0 + 8.0 * rise, 20.75 + 4.0 * rise, 20.5 + 0.25 * rise, speed, -12.0 * rise)
    return np.column_stack(columns).round(2)


def german(number: float) -> str:
    """Return a number with a decimal comma."""
    return f"{number:g}".replace(".", ",")


def table(
    times: Sequence[str] | None = None,
    *,
    clock: str = "",
    mark: str = ";",
    header: Sequence[str] = HEADER,
    values: np.ndarray | None = None,
    comma: bool = True,
) -> str:
    """Return a text table; its clock counts seconds, a row a minute, unless times are given."""
    clock = clock or ("Zeit [s]" if times is None else "Zeit")
    times = elapsed(ROWS if values is None else len(values)) if times is None else times
    values = signals(len(times)) if values is None else values
    told = german if comma else lambda number: f"{number:g}"
    lines = [mark.join([clock, *header])]
    for time, row in zip(times, values, strict=True):
        lines.append(mark.join([time, *(told(value) for value in row)]))
    return "\n".join(lines) + "\n"


def stamps(form: str, rows: int = ROWS, step_s: float = 60.0) -> list[str]:
    """Return local times, one for each row."""
    return [(START + dt.timedelta(seconds=step_s * n)).strftime(form) for n in range(rows)]


def elapsed(rows: int = ROWS, step: float = 60.0) -> list[str]:
    """Return elapsed times."""
    return [f"{step * n:.0f}" for n in range(rows)]


def workbook(path: Path, sheets: dict[str, list[list[Any]]]) -> Path:
    """Write an .xlsx or .xls file."""
    if path.suffix == ".xls":
        import xlwt

        old = xlwt.Workbook()
        style = xlwt.easyxf(num_format_str="YYYY-MM-DD HH:MM:SS")
        for name, rows in sheets.items():
            page = old.add_sheet(name)
            for at, row in enumerate(rows):
                for place, cell in enumerate(row):
                    if isinstance(cell, dt.datetime):
                        page.write(at, place, cell, style)
                    else:
                        page.write(at, place, cell)
        old.save(str(path))
        return path
    import openpyxl

    book = openpyxl.Workbook()
    book.remove(book.active)
    for name, rows in sheets.items():
        page = book.create_sheet(name)
        for row in rows:
            page.append(row)
    book.save(path)
    return path
