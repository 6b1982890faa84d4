"""``KEY=VALUE`` as a command line gives it."""

from __future__ import annotations

import tomllib
from typing import Any

from measurement.errors import BadInput


def assignment(text: str, option: str = "--set") -> tuple[str, Any]:
    """Return key and value of ``key=value``; the value is TOML, or else a plain text.

    Parameters
    ----------
    text : str
        As it stands on the command line.
    option : str
        Which option it belongs to, for the refusal.

    Returns
    -------
    key : str
    value
        A number, truth value, text, list or table.

    Raises
    ------
    BadInput
        If there is no key or no equals sign.
    """
    key, mark, value = text.partition("=")
    if not mark or not key.strip():
        raise BadInput(option, "", f"{text!r} is not of the form KEY=VALUE")
    try:
        return key.strip(), tomllib.loads(f"value = {value}")["value"]
    except (tomllib.TOMLDecodeError, RecursionError, ValueError):
        return key.strip(), value.strip()
