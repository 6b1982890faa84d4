"""What a machine's description may lack, one kind per file; a new file here is a new kind."""

from __future__ import annotations

from functools import cache

from gap_finder.kinds.base import CalibratedRun, Change
from plant_model.walk import classes_found


@cache
def kinds() -> dict[str, type[Change]]:
    """Return every kind of change by its name, in alphabetical order."""
    # mypy requires a concrete class when a type is passed; this one is never instantiated.
    return classes_found(__name__, __path__, Change, "gap/kinds kind")  # type: ignore[type-abstract]


__all__ = ["CalibratedRun", "Change", "kinds"]
