"""Build the FMUs: ``python build_fmu.py``. What it does is in `scenarios.building`."""

from __future__ import annotations

import sys

from scenarios.building import (
    DEFAULT_MACHINE,
    DEFAULT_MODEL,
    _arguments,
    compensator_recipe,
    main,
    plant_recipe,
)

__all__ = [
    "DEFAULT_MACHINE",
    "DEFAULT_MODEL",
    "_arguments",
    "compensator_recipe",
    "main",
    "plant_recipe",
]

if __name__ == "__main__":
    sys.exit(main())
