"""Build the FMUs: ``python build_fmu.py``. The code is in `scenarios.build_command`."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from pathlib import Path

from scenarios.entry import interrupted

try:
    from fmu_packaging.native.build import Native
    from fmu_packaging.package import Recipe
    from scenarios import build_command
    from scenarios.build_command import _arguments
    from scenarios.building import DEFAULT_MACHINE, DEFAULT_MODEL, compensator_recipe, plant_recipe
    from scenarios.cli import reported
except KeyboardInterrupt:
    if __name__ != "__main__":
        raise
    sys.exit(interrupted())

__all__ = [
    "DEFAULT_MACHINE",
    "DEFAULT_MODEL",
    "_arguments",
    "compensator_recipe",
    "main",
    "plant_recipe",
]


def _on_bus(recipe: Recipe, native: Native, dbc: Path | None, high: bool) -> Native:
    from gateway.native.build import native_on_bus  # slow to import, and few FMUs need it

    return native_on_bus(recipe, native, dbc, high=high)


def main(given: Sequence[str] | None = None) -> int:
    """Build what the command line asks for; return the exit code."""
    return build_command.main(given, _on_bus)


if __name__ == "__main__":
    sys.exit(reported(main))
