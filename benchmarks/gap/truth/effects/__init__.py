"""What can be hidden in the truth: everything that the catalogue names, and things it does not."""

from __future__ import annotations

import importlib
import pkgutil
from collections.abc import Iterable, Mapping
from functools import cache
from typing import Any, TypeVar

import numpy as np

from benchmarks.gap.truth.effects.base import SIZES, Hidden

T = TypeVar("T", bound="Any")


def found_in(path: Iterable[str], package: str, base: type[T]) -> dict[str, type[T]]:
    """Return all effects of a folder by name: subclasses of *base* that have one."""
    found: dict[str, type[T]] = {}
    for module in sorted(entry.name for entry in pkgutil.iter_modules(path)):
        for entry in vars(importlib.import_module(f"{package}.{module}")).values():
            if isinstance(entry, type) and issubclass(entry, base) and hasattr(entry, "name"):
                found[entry.name] = entry
    return dict(sorted(found.items()))


@cache
def everything() -> dict[str, type[Hidden]]:
    """Return all effects by name, found by walking this folder."""
    return found_in(__path__, __name__, Hidden)


def _planned() -> dict[str, type[Hidden]]:
    return {name: one for name, one in everything().items() if one.planned}


def catalogue() -> dict[str, type[Hidden]]:
    """Return the effects that the product's catalogue names, by name."""
    return {name: one for name, one in _planned().items() if one.catalogued}


OUTSIDE = tuple(name for name, one in _planned().items() if not one.catalogued)
"""Names of the effects that no catalogue holds."""


def make_effect(
    name: str, size: str | float, rng: np.random.Generator, channel: str | None = None
) -> Hidden:
    """Return an effect of this truth; see `make_from`."""
    return make_from(everything(), name, size, rng, channel)


def make_from(
    known: Mapping[str, type[T]],
    name: str,
    size: str | float,
    rng: np.random.Generator,
    channel: str | None = None,
) -> T:
    """Return an effect of a size by name (weak, medium, strong, within 15 %) or in its own unit.

    Parameters
    ----------
    known : mapping of str to type
        The effects that there are.
    name : str
    size : str or float
    rng : Generator
        Of everything about it that is drawn.
    channel : str, optional
        The sensor of an effect that acts on one; drawn when not given.
    """
    kind = known[name]
    spread = float(np.exp(rng.uniform(-0.15, 0.15)))
    if isinstance(size, str):
        size = kind.sizes[SIZES.index(size)] * spread
    drawn = str(rng.choice(kind.channels)) if kind.channels else ""
    return kind(size, rng, channel or drawn)
