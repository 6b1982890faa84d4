"""What can be hidden in the truth: everything that the catalogue names, and things it does not."""

from __future__ import annotations

import importlib
import pkgutil
from functools import cache

import numpy as np

from benchmarks.gap.truth.effects.base import SIZES, Hidden


@cache
def everything() -> dict[str, type[Hidden]]:
    """Return all effects by name, found by walking this folder."""
    found: dict[str, type[Hidden]] = {}
    for module in sorted(entry.name for entry in pkgutil.iter_modules(__path__)):
        for entry in vars(importlib.import_module(f"{__name__}.{module}")).values():
            if isinstance(entry, type) and issubclass(entry, Hidden) and hasattr(entry, "name"):
                found[entry.name] = entry
    return dict(sorted(found.items()))


def catalogue() -> dict[str, type[Hidden]]:
    """Return the effects that the product's catalogue names, by name."""
    return {name: one for name, one in everything().items() if one.catalogued}


OUTSIDE = tuple(name for name, one in everything().items() if not one.catalogued)
"""Names of the effects that no catalogue holds."""


def make_effect(
    name: str, size: str | float, rng: np.random.Generator, channel: str | None = None
) -> Hidden:
    """Return an effect of a size by name (weak, medium, strong, within 15 %) or in its own unit.

    Parameters
    ----------
    channel : str, optional
        The sensor of an effect that acts on one; drawn when not given.
    """
    kind = everything()[name]
    spread = float(np.exp(rng.uniform(-0.15, 0.15)))
    if isinstance(size, str):
        size = kind.sizes[SIZES.index(size)] * spread
    drawn = str(rng.choice(kind.channels)) if kind.channels else ""
    return kind(size, rng, drawn if channel is None else channel)
