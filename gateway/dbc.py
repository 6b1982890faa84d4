"""Reading DBC files with cantools, and the DBC file that ships."""

from __future__ import annotations

import logging
from math import isfinite
from pathlib import Path
from typing import Any

import cantools
from cantools.database.can import Database as CanDatabase

from measurement.errors import BadInput

logging.getLogger("cantools").addHandler(logging.NullHandler())  # what matters is refused below
DBC = Path(__file__).with_name("spindle_drift.dbc")


def load_dbc(path: Path) -> CanDatabase:
    """Return a DBC file as cantools reads it: in UTF-8, or else in Windows' Latin-1.

    Raises
    ------
    BadInput
        If it cannot be read, holds no frame, or two of one name.
    """
    try:
        data = path.read_bytes()
    except OSError as error:
        raise BadInput(path, "", f"cannot be read: {error.strerror}") from None
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError:
        text = data.decode("cp1252", "replace")
    try:
        read = cantools.database.load_string(text, database_format="dbc")
    except Exception as error:  # cantools and its parser raise many kinds of errors
        raise BadInput(path, "", f"is not a DBC file: {printable(str(error))}") from None
    assert isinstance(read, CanDatabase)
    if not read.messages:
        raise BadInput(path, "", "holds no frames")
    names = [message.name for message in read.messages]
    for message in read.messages:
        if names.count(message.name) > 1:
            raise BadInput(path, message.name, "is the name of two frames")
        for signal in message.signals:
            if not (isfinite(signal.scale) and signal.scale and isfinite(signal.offset)):
                problem = f"has the factor {signal.scale:g} and the offset {signal.offset:g}"
                raise BadInput(path, f"{message.name}.{signal.name}", problem)
    return read


def printable(text: str) -> str:
    """Return a foreign text as one line that is safe for a terminal."""
    return " ".join("".join(c if c.isprintable() else " " for c in text).split())


def attribute(specifics: Any, name: str, default: float) -> float:
    """Return an attribute's value: the object's own, or else the declared default."""
    entry = specifics.attributes.get(name) if specifics is not None else None
    if entry is None:
        return default
    return float(entry.value)
