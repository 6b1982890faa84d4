"""Effects from other installed distributions; a plant FMU does not contain this module."""

from __future__ import annotations

from collections.abc import Collection
from functools import cache

from measurement.plugins import EFFECTS, PlugIn, classes_plugged_in
from plant_model.effects.base import Effect


@cache
def plugged_effects(shipped: Collection[str]) -> dict[str, PlugIn[type[Effect]]]:
    """Return the effects of plug-ins, by name.

    Parameters
    ----------
    shipped : frozenset of str
        Names of the project's own effects.

    Raises
    ------
    BadInput
        For a plug-in that is not an effect.
    """
    plugins = classes_plugged_in(EFFECTS, Effect, shipped)
    for plugin in plugins.values():
        problem = _problem(plugin.name, plugin.thing)
        if problem:
            raise plugin.refuse(problem)
    return plugins


def _problem(name: str, effect: type[Effect]) -> str:
    """Return what is wrong with an effect, or an empty text."""
    missing = [
        field
        for field in ("name", "title", "explanation", "parameters", "amplitude")
        if not hasattr(effect, field)
    ]
    if missing:
        return f"{effect.__qualname__} lacks {', '.join(missing)}"
    if effect.name != name:
        return f"{effect.__qualname__} is called {effect.name}: both names must be the same"
    if effect.amplitude not in effect.parameters:
        return f"the amplitude {effect.amplitude} is none of its parameters"
    return "; ".join(
        f"parameter {key}: {parameter.value:g} is outside {parameter.low:g}..{parameter.high:g}"
        for key, parameter in effect.parameters.items()
        if not parameter.low <= parameter.value <= parameter.high
    )


def plugged_modules() -> set[str]:
    """Return the names of the modules that define the effects of plug-ins."""
    from plant_model.effects import shipped_effects

    plugins = plugged_effects(frozenset(shipped_effects()))
    return {plugin.thing.__module__ for plugin in plugins.values()}
