"""Reads dates and times of day as recorders and spreadsheets write them."""

from __future__ import annotations

import calendar
import datetime as dt
import re
from collections.abc import Sequence

from measurement.importing.cells import Cell

DAY_S = 86400.0
SINCE_1904_S, SINCE_1900_S = 2_082_844_800.0, 2_209_161_600.0
SINCE_1601_S = 11_644_473_600.0
"""A day, and how long before 1970 the clocks of LabVIEW, a spreadsheet and Windows begin [s], given
by arithmetic; a spreadsheet's at the end of 1899."""
_OF_DAY = re.compile(
    r"(?:(?P<d>\d+)\s*d\s*)?(?P<h>\d{1,3}):(?P<m>\d{2})(?::(?P<s>\d{2})(?:[.,:](?P<part>\d+))?)?"
    r"\s*(?P<half>[AaPp][Mm])?"
)
_ZONE = re.compile(r"\s*(?:(?P<utc>Z|UTC|GMT)|(?P<sign>[+-])(?P<h>\d{2}):?(?P<m>\d{2})?)$")
_DATE = re.compile(r"(?P<a>\d{1,4})(?P<mark>[-./])(?P<b>\d{1,2})(?P=mark)(?P<c>\d{1,4})")
_WORDED = re.compile(r"(?P<a>\d{1,2})[-. /]+(?P<b>[A-Za-zä]{3})[a-zä]*[-. ,/]+(?P<c>\d{2,4})")
_MONTHS = {name.lower(): number for number, name in enumerate(calendar.month_abbr) if name}
_MONTHS |= {"mär": 3, "mrz": 3, "mai": 5, "okt": 10, "dez": 12}
_EPOCH = dt.datetime(1970, 1, 1)


def seconds_of_day(cell: Cell) -> float | None:
    """Return a time of day, or an elapsed time such as 26:10:00 [s]; None if it is neither.

    >>> seconds_of_day("1:02:03,5"), seconds_of_day("02:15 pm"), seconds_of_day("noon")
    (3723.5, 51300.0, None)
    """
    if isinstance(cell, dt.timedelta):
        return cell.total_seconds()
    if isinstance(cell, dt.time):
        return cell.hour * 3600.0 + cell.minute * 60.0 + cell.second + cell.microsecond / 1e6
    match = _OF_DAY.fullmatch(cell.strip()) if isinstance(cell, str) else None
    if not match:
        return None
    hour = int(match["h"])
    if match["half"]:
        hour = hour % 12 + (12 if match["half"].lower() == "pm" else 0)
    part = float(f"0.{match['part']}") if match["part"] else 0.0
    whole = int(match["d"] or 0) * DAY_S + hour * 3600.0 + int(match["m"]) * 60.0
    return whole + int(match["s"] or 0) + part


def seconds_of_date(text: str, day_first: bool) -> float | None:
    """Return the seconds since 1970 of a date with or without time of day; None if it is no date.

    With a zone the time is converted to UTC, otherwise it is as the clock showed it.

    >>> seconds_of_date("01.02.1970", True), seconds_of_date("1970-01-01T01:00:00+01:00", True)
    (2678400.0, 0.0)
    """
    text = text.strip()
    match = _DATE.match(text) or _WORDED.match(text)
    day = _day(match, day_first) if match else None
    if match is None or day is None:
        return None
    rest = text[match.end() :].lstrip(" T,_")
    zone = _ZONE.search(rest) if rest else None
    ahead = 0.0
    if zone:
        rest = rest[: zone.start()]
        if zone["sign"]:
            ahead = int(zone["h"]) * 3600.0 + int(zone["m"] or 0) * 60.0
            ahead = -ahead if zone["sign"] == "-" else ahead
    seconds = seconds_of_day(rest) if rest else 0.0
    return None if seconds is None else (day - _EPOCH).total_seconds() + seconds - ahead


def has_zone(text: str) -> bool:
    """Return whether a date with a time of day also has its zone.

    >>> has_zone("2024-06-01T20:00Z"), has_zone("2024-06-01")
    (True, False)
    """
    match = _DATE.match(text.strip()) or _WORDED.match(text.strip())
    return bool(match and _ZONE.search(text.strip()[match.end() :]))


def _day(match: re.Match[str], day_first: bool) -> dt.datetime | None:
    first, middle, last = match["a"], match["b"], match["c"]
    if not middle.isdigit():
        year, month, day = int(last), _MONTHS.get(middle.lower(), 0), int(first)
    elif len(first) == 4:
        year, month, day = int(first), int(middle), int(last)
    else:
        day, month = (int(first), int(middle)) if day_first else (int(middle), int(first))
        year = int(last)
    if year < 100:
        year += 2000
    try:
        return dt.datetime(year, month, day)
    except ValueError:
        return None


def day_comes_first(texts: Sequence[str]) -> bool | None:
    """Return whether the day comes before the month in dates; None if ambiguous.

    Dates that begin with the year, or name the month, give True: they are unambiguous.
    """
    dates = [match for text in texts if (match := _DATE.match(text.strip()))]
    if not dates or any(len(match["a"]) == 4 for match in dates) or dates[0]["mark"] == ".":
        return True
    first, second = ({int(match[key]) for match in dates} for key in "ab")
    if max(first) > 12:
        return True
    if max(second) > 12:
        return False
    return True if first == second else None


def is_date(cell: Cell) -> bool:
    """Return whether a cell holds a date, with or without a time of day."""
    if isinstance(cell, dt.date):
        return True
    if not isinstance(cell, str):
        return False
    return seconds_of_date(cell, True) is not None or seconds_of_date(cell, False) is not None


def is_only_date(cell: Cell) -> bool:
    """Return whether a cell holds a date without a time of day."""
    if isinstance(cell, dt.datetime):
        return cell.time() == dt.time()
    return isinstance(cell, dt.date) or (
        isinstance(cell, str) and is_date(cell) and ":" not in cell
    )


def as_text(cell: Cell) -> str:
    """Return a cell of time as text."""
    if isinstance(cell, dt.datetime):
        return cell.isoformat(" ")
    return "" if cell is None else str(cell)
