"""Logs with a JSON object per row, one per line or all in one list."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from measurement.errors import BadInput
from measurement.importing.cells import Sheet
from measurement.importing.logs import sheet_of


def is_json(text: str) -> bool:
    """Return whether a text begins like such a log."""
    return "".join(text[:80].split()).startswith(("{", "[{"))


def read_json(path: Path, text: str) -> list[Sheet]:
    """Read one table, or none; nested objects and lists become separate columns.

    Raises
    ------
    BadInput
        For the first row that is not a JSON object.
    """
    if text.lstrip().startswith("["):
        objects = _parsed(path, "", text)
    else:
        lines = enumerate(text.splitlines(), 1)
        objects = [_parsed(path, f"row {row}", line) for row, line in lines if line.strip()]
    odd = next((row for row, item in enumerate(objects, 1) if not isinstance(item, dict)), None)
    if odd is not None:
        raise BadInput(path, f"row {odd}", "is no JSON object with names")
    try:
        rows = [_flat(path, row, item) for row, item in enumerate(objects, 1)]
    except RecursionError:
        raise BadInput(path, "", "holds objects within objects, too deep for a row") from None
    names = dict.fromkeys(name for row in rows for name in row)
    channels = [(name, "", [row.get(name) for row in rows]) for name in names]
    return [sheet_of(path, "", channels)] if channels else []


def _flat(path: Path, row: int, value: dict[str, Any]) -> dict[str, Any]:
    """Return the values of an object and its nested objects, by their joined names."""
    cells: dict[str, Any] = {}
    for name, cell in _leaves("", value):
        if name in cells:
            raise BadInput(path, f"row {row}", f"holds {name!r} twice (apart from blanks)")
        cells[name] = cell
    return cells


def _leaves(name: str, value: Any) -> Iterator[tuple[str, Any]]:
    if isinstance(value, list):  # its entries count from 1
        value = dict(enumerate(value, 1))
    if isinstance(value, dict):
        for key, part in value.items():
            yield from _leaves(" ".join(f"{name} {key}".split()), part)
    else:
        yield name, None if value != value else value


def _parsed(path: Path, place: str, text: str) -> Any:
    try:
        # An integer too large for a double becomes infinite, which no unit's range allows.
        return json.loads(text, parse_int=float)
    except (ValueError, RecursionError) as error:
        raise BadInput(path, place, f"is no JSON: {error}") from None
