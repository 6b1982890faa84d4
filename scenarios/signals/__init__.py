"""The signals that drive a scenario: one kind per file, found by walking this folder.

A new kind is a new file with one class derived from :class:`~scenarios.signals.base.Signal`; its
fields, with their bounds, are those allowed in a scenario file.
"""

from __future__ import annotations

from functools import cache
from pathlib import Path
from typing import get_args

from measurement.errors import BadInput, checked, near, shown
from measurement.walk import classes_of
from scenarios.signals.base import Setting, Signal


@cache
def kinds() -> dict[str, type[Signal]]:
    """Return every kind of signal by its name."""
    every = classes_of(__name__, Path(__file__).parent, Signal)  # type: ignore[type-abstract]
    return {get_args(kind.model_fields["kind"].annotation)[0]: kind for kind in every}


def build(entry: object, setting: Setting) -> Signal:
    """Return the signal that an entry of a scenario file describes.

    Parameters
    ----------
    entry : object
        A number, or a table with a ``kind``.
    setting : Setting
        Its context.

    Raises
    ------
    BadInput
        If it is neither, of an unknown kind, or has a wrong field.
    """
    if isinstance(entry, int | float) and not isinstance(entry, bool):
        entry = {"kind": "constant", "value": entry}
    if not isinstance(entry, dict):
        raise BadInput(
            setting.source,
            setting.place,
            f"{shown(entry)} is not allowed: a number, or a table with a kind, is needed",
        )
    kind = entry.get("kind")
    if not isinstance(kind, str) or kind not in kinds():
        problem = "is missing" if kind is None else f"{shown(kind)} is not a kind of signal"
        raise BadInput(
            setting.source,
            f"{setting.place}.kind",
            f"{problem}: {', '.join(sorted(kinds()))}{near(kind, kinds())}",
        )
    signal = checked(kinds()[kind], entry, setting.source, setting.place)
    try:
        kinds()[kind].place(setting, entry)
    except RecursionError:
        raise BadInput(setting.source, "signals", "sums nest too deep") from None
    return signal
