"""Physical effects, one file each; a new file in this folder is a new effect.

The package walks its own folder at import, so that it also works in a plant FMU, which contains it
under another name. Plug-ins add further effects; an FMU contains those that its machine uses as
files in this folder.
"""

from __future__ import annotations

from functools import cache

from plant_model.effects.base import Effect
from plant_model.item_forms import ItemSpec
from plant_model.walk import classes_found


@cache
def shipped_effects() -> dict[str, type[Effect]]:
    """Return the effects of this folder by name, in alphabetical order."""
    return classes_found(__name__, __path__, Effect, "effects effect")


@cache
def catalogue() -> dict[str, type[Effect]]:
    """Return all effects by name, including those of plug-ins, in alphabetical order.

    Raises
    ------
    BadInput
        For a plug-in that cannot be used.
    """
    shipped = shipped_effects()
    try:
        from plant_model.plugins import plugged_effects
    except ImportError:  # in an FMU
        return shipped
    more = {name: plugin.thing for name, plugin in plugged_effects(frozenset(shipped)).items()}
    return dict(sorted({**shipped, **more}.items()))


@cache
def item_kinds() -> dict[tuple[str, str], tuple[str, ItemSpec]]:
    """Return, for each (family, kind) of item, the effect that defines its law, and its form."""
    return {
        key: (effect.name, spec)
        for effect in catalogue().values()
        for key, spec in effect.handles.items()
    }


__all__ = ["Effect", "ItemSpec", "catalogue", "item_kinds", "shipped_effects"]
