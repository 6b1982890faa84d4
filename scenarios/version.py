"""The program's name and version."""

from __future__ import annotations

from functools import cache

PROGRAM = "spindle-drift"


@cache
def version() -> str:
    """Return the installed version."""
    from importlib import metadata

    try:
        return metadata.version(PROGRAM)
    except metadata.PackageNotFoundError:
        return "(not installed)"
