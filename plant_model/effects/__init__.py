"""Physical effects, one file each; a new file in this folder is a new effect.

The folder is walked at import, relative to wherever the package lives, so that it also works when
the plant FMU carries the package under another name.
"""

from __future__ import annotations

import importlib
import pkgutil
from functools import cache

from plant_model.effects.base import Effect, ItemSpec


@cache
def catalogue() -> dict[str, type[Effect]]:
    """Return every effect by its name, in alphabetical order."""
    found: dict[str, type[Effect]] = {}
    for module in sorted(entry.name for entry in pkgutil.iter_modules(__path__)):
        if module == "base":
            continue
        classes = [
            entry
            for entry in vars(importlib.import_module(f"{__name__}.{module}")).values()
            if isinstance(entry, type) and issubclass(entry, Effect) and entry is not Effect
        ]
        if len(classes) != 1 or classes[0].name != module:
            raise ImportError(f"effects/{module}.py must hold one effect, and of the file's name")
        found[module] = classes[0]
    return found


@cache
def item_kinds() -> dict[tuple[str, str], tuple[str, ItemSpec]]:
    """Return, for every (family, kind) of item, the effect that gives it its law and its form."""
    return {
        key: (effect.name, spec)
        for effect in catalogue().values()
        for key, spec in effect.handles.items()
    }


__all__ = ["Effect", "ItemSpec", "catalogue", "item_kinds"]
