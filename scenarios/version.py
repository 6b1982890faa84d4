"""The program's name and version."""

from __future__ import annotations

from importlib import metadata

PROGRAM = "spindle-drift"


def version() -> str:
    """Return the installed version."""
    try:
        return metadata.version(PROGRAM)
    except metadata.PackageNotFoundError:
        return "(not installed)"
