"""Reads ``KEY=VALUE`` and numbers with a unit from the command line."""

from __future__ import annotations

import json
import re
import tomllib
from collections.abc import Callable
from typing import Any

from measurement.errors import BadInput, shown
from measurement.importing.quantities import conversion_of


def from_toml(text: str) -> Any:
    """Return a value written as in a scenario file: a number, boolean, text, list or table."""
    return tomllib.loads(f"value = {text}")["value"]


def assignment(
    text: str,
    option: str = "--set",
    form: str = "KEY=VALUE",
    read: Callable[[str], Any] = from_toml,
) -> tuple[str, Any]:
    """Return key and value of ``key=value``; a value that cannot be read is plain text.

    Parameters
    ----------
    text : str
        As given on the command line.
    option, form : str
        The option and its form, for the refusal.
    read : callable
        Converts the value.

    Raises
    ------
    BadInput
        If there is no key or no equals sign.
    """
    key, mark, value = (part.strip() for part in text.partition("="))
    if not mark or not key:
        raise BadInput(option, "", f"{text!r} is not of the form {form}")
    try:
        return key, read(value)
    except (RecursionError, ValueError):
        return key, value


def options_of(texts: list[str], form: str = "NAME=VALUE") -> dict[str, Any]:
    """Return the value of each ``--option NAME=VALUE`` by name; the value is JSON or a word.

    Raises
    ------
    BadInput
        For a text without a name or an equals sign.
    """
    return dict(assignment(text, "--option", form, json.loads) for text in texts)


def quantity(
    option: str, text: str, suffix: str, low: float, high: float, usual: str = ""
) -> float:
    """Return an option's number with a unit, such as ``60s`` or ``3um``.

    Parameters
    ----------
    option, text : str
        The option and what was given.
    suffix : str
        The run file's unit in which it is wanted.
    low, high : float
        Its range, in that unit.
    usual : str
        The unit of a number without one; by default it needs one.

    Raises
    ------
    BadInput
        If it is no such number, or out of range.
    """
    match = re.fullmatch(r"\s*([0-9]*\.?[0-9]+(?:e[+-]?[0-9]+)?)\s*([a-z]*)\s*", text)
    kind = conversion_of(match[2] or usual) if match else None
    value = kind.factor * float(match[1]) if match and kind and kind.suffix == suffix else -1.0
    if not low <= value <= high:
        allowed = f"a number with its unit, {low:g} to {high:g} {suffix}"
        raise BadInput(option, "", f"{shown(text)} is not allowed: {allowed}")
    return value
