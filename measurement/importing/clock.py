"""Reads the time of a table's rows: elapsed, local or ISO 8601, in one column or two."""

from __future__ import annotations

import datetime as dt
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cache
from zoneinfo import ZoneInfo, ZoneInfoNotFoundError

import numpy as np
import pandas as pd

from measurement.errors import BadInput, shown
from measurement.importing.cells import Cell, Sheet, is_missing
from measurement.importing.mapping import TimeRule
from measurement.importing.quantities import conversion_of
from measurement.importing.stamps import (
    DAY_S,
    SINCE_1601_S,
    SINCE_1900_S,
    SINCE_1904_S,
    as_text,
    day_comes_first,
    has_zone,
    is_date,
    is_only_date,
    seconds_of_date,
    seconds_of_day,
)
from measurement.importing.values import is_numeric, numbers_of, read_cells
from measurement.resampling import FloatArray
from measurement.runs import HOUR_S

ZEROS_S = {"d": (SINCE_1900_S,), "0.1 us": (SINCE_1601_S,)} | dict.fromkeys(
    ("s", "ms", "us", "ns"), (0.0, SINCE_1904_S)
)
"""By unit, the epochs from which a clock's numbers may count [s before 1970]."""
RECORDED_S = (4.7e8, 2.5e9)
"""A number is a date if it falls between these [s since 1970]: 1985 to 2049, which leaves one of
two possible epochs. Set on no data."""
MOST_S_OF_A_STAMP = 60.0
"""Rows that share a time stamp are spread over it if the next stamp follows within this time [s]:
given by stamps of hours and minutes, the coarsest that a clock writes."""


@dataclass(frozen=True)
class Clock:
    """When a table's rows were taken.

    Attributes
    ----------
    time_s : array, shape (rows,)
        Seconds since 1970 if *absolute* (by the recorder's clock, or UTC if the zone is known),
        else since a zero of the recorder.
    absolute : bool
    columns : tuple of int
        The sheet's columns that hold the time.
    rule : TimeRule
        How it was read, for the mapping file.
    shared : int
        Number of rows with the same time stamp as the row before.
    of_day : bool
        Whether time counts from midnight of an unknown day.
    newest_first : bool
        Whether the sheet's rows are in the reverse order.
    """

    time_s: FloatArray
    absolute: bool
    columns: tuple[int, ...]
    rule: TimeRule
    shared: int = 0
    of_day: bool = False
    newest_first: bool = False

    def on_day_of(self, dated: Clock) -> Clock:
        """Return a clock of times of day on the day that puts its start next to a dated one's."""
        days = round(float(dated.time_s[0] - self.time_s[0]) / DAY_S)
        return replace(self, time_s=self.time_s + days * DAY_S, absolute=True, of_day=False)


def clock_of(sheet: Sheet, rule: TimeRule | None = None) -> Clock:
    """Find and read the time of a sheet.

    Parameters
    ----------
    sheet : Sheet
    rule : TimeRule, optional
        From a mapping file; what it leaves open is detected.

    Raises
    ------
    BadInput
        If there is no time, it is ambiguous, or it goes backwards.
    """
    rule = rule or TimeRule()
    if rule.every_row_s:
        named = tuple(i for i, entry in enumerate(sheet.headings) if entry.is_time)
        rows = np.arange(len(sheet.rows), dtype=np.float64)
        return Clock(rule.every_row_s * rows, False, named, rule)
    at = _columns(sheet, rule)
    absolute = of_day = False
    if len(at) == 1 and is_numeric(sheet, at[0]):
        time, absolute, rule = _elapsed(sheet, at[0], rule)
    elif len(at) == 1 and _all(sheet.columns[at[0]], _is_of_day):
        cells = sheet.columns[at[0]]
        time = _passing_midnight(read_cells(sheet, at[0], cells, _time_of_day, "time"))
        of_day = True
    else:
        time, rule = _dated(sheet, at, rule)
        absolute = True
    steps = np.diff(time)
    newest_first = bool((absolute or of_day) and (steps <= 0.0).all() and (steps < 0.0).any())
    if newest_first:
        sheet, time = sheet.turned(), time[::-1]
    time, shared = _ordered(sheet, at[0], time, dated=absolute)
    names = [sheet.headings[column].text for column in at]
    rule = rule.model_copy(update={"columns": names})
    return Clock(time, absolute, at, rule, shared, of_day, newest_first)


def _columns(sheet: Sheet, rule: TimeRule) -> tuple[int, ...]:
    """Return the column of the time, or those of date and time of day."""
    texts = [entry.text for entry in sheet.headings]
    given = [texts.index(name) for name in rule.columns if name in texts]
    if given:
        return tuple(given)
    named = [i for i, entry in enumerate(sheet.headings) if entry.is_time]
    days = [i for i, cells in enumerate(sheet.columns) if _all(cells, is_only_date)]
    hours = [i for i, cells in enumerate(sheet.columns) if _all(cells, _is_of_day)]
    if days and hours:
        return days[0], hours[0]
    dated = [i for i, cells in enumerate(sheet.columns) if _all(cells, is_date)]
    for columns in (dated, hours, named):
        if columns:
            return ((columns[0]),)
    first = conversion_of(sheet.headings[0].unit) if sheet.headings[0].unit else None
    if first is not None and first.suffix == "s":
        return (0,)
    problem = (
        f"has no column of time: none of {', '.join(texts)} has such a name or such values. --time "
        "NAME names it; --every-row 60s says that a row follows the last after 60 s"
    )
    raise BadInput(sheet.where, "", problem)


def _elapsed(sheet: Sheet, at: int, rule: TimeRule) -> tuple[FloatArray, bool, TimeRule]:
    """Return numbers as seconds, and whether they count since 1970."""
    entry = sheet.headings[at]
    values = numbers_of(sheet, at)
    unit = rule.unit or entry.unit
    middle = float(np.nanmedian(values))
    unit = unit or next((each for each in ZEROS_S if _zero_s(middle, each) is not None), "")
    kind = conversion_of(unit) if unit else None
    if kind is None or kind.suffix != "s":
        said = (
            f"{shown(unit or entry.said)} is no unit of time" if unit or entry.said else "no unit"
        )
        problem = f"{said}: say it, as in --unit '{entry.text}=s' (s, ms, min, h, or d for days)"
        raise BadInput(sheet.where, f"column {entry.text}", problem)
    zero = _zero_s(middle, unit)
    time = kind(values) - (zero or 0.0)
    if zero == SINCE_1900_S and rule.timezone:  # a spreadsheet counts by the clock on the wall
        time = _universal(sheet, f"column {entry.text}", time, rule.timezone)
    return time, zero is not None, rule.model_copy(update={"unit": unit})


def _zero_s(value: float, unit: str) -> float | None:
    """Return how long before 1970 a clock's zero is [s]; None if it counts from its start."""
    kind = conversion_of(unit)
    seconds = float(kind(np.array([value]))[0]) if kind else math.nan
    zeros = next((zeros_s for each, zeros_s in ZEROS_S.items() if conversion_of(each) == kind), ())
    return next((z for z in zeros if RECORDED_S[0] < seconds - z < RECORDED_S[1]), None)


def _dated(sheet: Sheet, at: Sequence[int], rule: TimeRule) -> tuple[FloatArray, TimeRule]:
    """Return dates as seconds since 1970."""
    columns = [sheet.columns[i] for i in at]
    name = f"column {sheet.headings[at[0]].text}"
    texts = [_joined([column[row] for column in columns]) for row in range(len(sheet.rows))]
    if rule.day_first is None:
        rule = rule.model_copy(update={"day_first": day_comes_first(texts)})
    if rule.day_first is None:
        problem = f"{texts[0]} can be read in two ways: use --day-first or --month-first"
        raise BadInput(sheet.where, name, problem)
    day_first = rule.day_first
    read = cache(lambda text: seconds_of_date(text, day_first) if text else math.nan)
    time = read_cells(sheet, at[0], texts, read, "time")
    if rule.timezone and not any(map(has_zone, texts)):
        time = _universal(sheet, name, time, rule.timezone)
    return time, rule


def _joined(cells: Sequence[Cell]) -> str:
    """Return a date, or a date and its time of day, as one text."""
    if len(cells) == 2 and isinstance(cells[0], (dt.datetime, dt.date)):
        hours = cells[1]
        if isinstance(hours, dt.datetime):  # a workbook's time of day, on an arbitrary day
            hours = hours.time()
        return f"{cells[0].isoformat()[:10]} {as_text(hours)}".strip()
    return " ".join(as_text(cell) for cell in cells).strip()


def _universal(sheet: Sheet, name: str, time: FloatArray, zone: str) -> FloatArray:
    """Return local times as UTC, so that the hour repeated in autumn stays two hours."""
    try:
        ZoneInfo(zone)
    except (ZoneInfoNotFoundError, ValueError, OSError):
        problem = f"{zone!r} is no time zone; a name such as Europe/Berlin is needed"
        raise BadInput(sheet.where, name, problem) from None
    local = pd.Series(pd.to_datetime(time, unit="s"))
    try:
        there = local.dt.tz_localize(zone, ambiguous="infer")
    except ValueError as error:
        raise BadInput(sheet.where, name, f"does not fit {zone}: {error}") from None
    zero = pd.Timestamp(0, tz="UTC")
    return np.asarray((there - zero).dt.total_seconds(), dtype=np.float64)


def _time_of_day(cell: Cell) -> float | None:
    return math.nan if is_missing(cell) else seconds_of_day(cell)


def _passing_midnight(time: FloatArray) -> FloatArray:
    """Return times of day with a day added after each midnight."""
    back = np.diff(time, prepend=time[:1]) < -DAY_S / 2.0
    return np.asarray(time + DAY_S * np.cumsum(back))


def _ordered(sheet: Sheet, at: int, time: FloatArray, *, dated: bool) -> tuple[FloatArray, int]:
    """Check that time is present and never goes backwards, and spread rows that share a stamp.

    Recorders that write whole seconds or minutes give several rows the same stamp.
    """
    name = f"column {sheet.headings[at].text}"

    def refuse(row: int, problem: str) -> BadInput:
        return BadInput(sheet.where, f"row {sheet.rows[row]}, {name}", problem)

    missing = np.flatnonzero(~np.isfinite(time))
    if missing.size:
        raise refuse(int(missing[0]), "is missing; every row needs a time")
    steps = np.diff(time)
    back = np.flatnonzero(steps < 0.0)
    if back.size:
        row = int(back[0]) + 1
        problem = f"{_told(time[row], dated)} is before {_told(time[row - 1], dated)}, the last row"
        if not dated:
            problem += "; if the recorder began anew, make two files of it"
        if round(steps[row - 1] / HOUR_S) == -1:
            cure = (
                "--timezone Europe/Berlin mends it" if dated else f"add {HOUR_S:g} s from there on"
            )
            problem += f"; if clocks were set back by an hour, {cure}"
        raise refuse(row, problem)
    same = np.flatnonzero(steps == 0.0) + 1
    if not same.size:
        return time, 0
    fresh = np.flatnonzero(np.diff(time, prepend=-np.inf) > 0.0)
    between = np.diff(time[fresh])
    if not between.size or np.median(between) > MOST_S_OF_A_STAMP:
        row = int(same[0])
        raise refuse(row, f"has the same time as the previous row, {_told(time[row], dated)}")
    counts = np.diff(np.append(fresh, len(time)))
    width = np.minimum(np.append(between, np.median(between)), MOST_S_OF_A_STAMP)
    within = np.arange(len(time)) - np.repeat(fresh, counts)
    return np.asarray(time + within * np.repeat(width / counts, counts)), int(same.size)


def _told(time_s: float, dated: bool) -> str:
    return str(pd.Timestamp(time_s, unit="s")) if dated else f"{time_s:g} s"


def _all(cells: list[Cell], kind: Callable[[Cell], bool]) -> bool:
    some = [cell for cell in cells[:20] if not is_missing(cell)]
    return bool(some) and all(map(kind, some))


def _is_of_day(cell: Cell) -> bool:
    return seconds_of_day(cell) is not None
