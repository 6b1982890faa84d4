"""Logs with a JSON object for each row, one a line or all in one list."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pandas as pd

from measurement.errors import BadInput
from measurement.importing.headers import headings
from measurement.importing.logs import sheet_of
from measurement.importing.sheets import Sheet


def is_json(text: str) -> bool:
    """Return whether a text begins as such a log does."""
    return "".join(text[:80].split()).startswith(("{", "[{"))


def read_json(path: Path, text: str) -> list[Sheet]:
    """Read one table, or none; objects and lists within a row become columns of their own.

    Raises
    ------
    BadInput
        For the first row that is no JSON object.
    """
    if text.lstrip().startswith("["):
        objects = _parsed(path, "", text)
    else:
        lines = enumerate(text.splitlines(), 1)
        objects = [_parsed(path, f"row {row}", line) for row, line in lines if line.strip()]
    odd = next((row for row, one in enumerate(objects, 1) if not isinstance(one, dict)), None)
    if odd is not None:
        raise BadInput(path, f"row {odd}", "is no JSON object with names")
    try:
        frame = pd.json_normalize([_named(one) for one in objects], sep=" ")
    except RecursionError:
        raise BadInput(path, "", "holds objects within objects, too deep for a row") from None
    cells = [[None if pd.isna(one) else one for one in frame[name].tolist()] for name in frame]
    named = headings(list(frame.columns), [""] * len(cells))
    return [sheet_of(path, "", dict(zip(named, cells, strict=True)))] if cells else []


def _named(value: Any) -> Any:
    """Return a value with lists as objects, whose names count from 1."""
    if isinstance(value, list):
        value = dict(enumerate(value, 1))
    return {str(k): _named(v) for k, v in value.items()} if isinstance(value, dict) else value


def _parsed(path: Path, place: str, text: str) -> Any:
    try:
        # A whole number may be too large for a double, which then says that there is no value.
        return json.loads(text, parse_int=float)
    except (ValueError, RecursionError) as error:
        raise BadInput(path, place, f"is no JSON: {error}") from None
