"""What a machine's description may lack, one kind a file; a new file here is a new kind."""

from __future__ import annotations

import importlib
import pkgutil
from functools import cache

from plant_model.gap.kinds.base import Change, Known


@cache
def kinds() -> dict[str, type[Change]]:
    """Return every kind of change by its name, in alphabetical order."""
    found: dict[str, type[Change]] = {}
    for module in sorted(entry.name for entry in pkgutil.iter_modules(__path__)):
        if module == "base":
            continue
        classes = [
            entry
            for entry in vars(importlib.import_module(f"{__name__}.{module}")).values()
            if isinstance(entry, type) and issubclass(entry, Change) and entry is not Change
        ]
        if len(classes) != 1 or classes[0].name != module:
            raise ImportError(f"gap/kinds/{module}.py must hold one kind, and of the file's name")
        found[module] = classes[0]
    return found


__all__ = ["Change", "Known", "kinds"]
