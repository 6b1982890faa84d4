"""The program's name and version."""

from __future__ import annotations

PROGRAM = "spindle-drift"


def version() -> str:
    """Return the installed version."""
    from importlib import metadata

    try:
        return metadata.version(PROGRAM)
    except metadata.PackageNotFoundError:
        return "(not installed)"
