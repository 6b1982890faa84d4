"""The form of an effect that a simulator can hide: a law, and a row of numbers for each machine.

A law is a subclass of `Hidden`: what it does to heat, conductances, pose or readings. Those common
to all simulators are in `benchmarks.gap.laws`, those of one machine in its own ``effects.py``. The
machine's ``effects.toml`` has a row for each effect that it can hide.
"""

from __future__ import annotations

import re
import tomllib
from collections.abc import Mapping, Sequence
from pathlib import Path
from types import ModuleType
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
import pandas as pd

from benchmarks.gap.drive import Array, Drive

if TYPE_CHECKING:
    from benchmarks.gap.march import Now

SIZES = ("weak", "medium", "strong")
X, Y, E = range(3)
"""The first columns of every simulator's pose: x, y and elongation [um]."""


class Hidden:
    """Base class of everything that can be hidden; it does nothing by default.

    Attributes
    ----------
    size : float
        Its amplitude; at 0 the effect vanishes exactly.
    channel : str
        The sensor that it acts on, if any.
    """

    name: ClassVar[str]
    """Its class name in snake case, unless its row has another."""
    unit: ClassVar[str]
    sizes: ClassVar[Sequence[float]]
    """Amplitudes called weak, medium and strong."""
    beyond: ClassVar[float] = 0.0
    """An amplitude beyond the usual, where the simulator means by it what the catalogue does."""
    channels: ClassVar[Sequence[str]] = ()
    catalogued: ClassVar[bool] = True
    in_other_words: ClassVar[Sequence[tuple[str, Sequence[str]]]] = ()
    """Equivalent changes of the machine's file, kind and place; ``*`` is any part."""
    drawn: ClassVar[Mapping[str, Any]] = {}
    """Its other numbers: ends to draw between (evenly, or an integer below the second), or the
    probability of 1 instead of -1."""

    def __init_subclass__(cls, **row: Any) -> None:
        """Name it after its class, and take the numbers of its row."""
        cls.name = re.sub(r"(?<!^)(?=[A-Z])", "_", cls.__name__).lower()
        for key, value in row.items():
            setattr(cls, key, value)

    def __init__(self, size: float, rng: np.random.Generator, channel: str = "") -> None:
        self.size, self.channel = float(size), channel
        self.more: dict[str, float] = {}
        """Its other numbers, for the answers file."""
        self.draw(rng)

    def draw(self, rng: np.random.Generator) -> None:
        """Draw all numbers except the size."""
        for name, ends in self.drawn.items():
            if isinstance(ends, float):
                self.more[name] = 1.0 if rng.random() < ends else -1.0
            else:
                draw = rng.integers if isinstance(ends[0], int) else rng.uniform
                self.more[name] = float(draw(*ends))

    def begin(self, machine: Any, drive: Drive) -> None:
        """Reset its states at the start of a run."""

    def friction(self, now: Now, viscous: Array, load: Array) -> tuple[Array, Array]:
        """Return the changed heat of every bearing or set of bearings [W]."""
        return viscous, load

    def heat(self, now: Now, out: Array) -> None:
        """Add heat [W]."""

    def scales(self, now: Now) -> dict[str, float]:
        """Return factors on groups of conductances."""
        return {}

    def boundaries(self, now: Now, values: Array) -> None:
        """Change the boundary temperatures, in place [degC]; of the jig borer only."""

    def advance(self, now: Now, step: float) -> None:
        """Step the effect's own states."""

    def move(self, machine: Any, drive: Drive, temperatures: Array, pose: Array) -> None:
        """Change the pose in place, row by row; temperatures are (rows, unknowns)."""

    def record(self, number: int, machine: Any, drive: Drive, shown: pd.DataFrame) -> None:
        """Change the sensor readings in place; *number* counts the case's runs from 0."""


def variant(law: type[Hidden], name: str, **row: Any) -> type[Hidden]:
    """Return a law with the numbers of a row, and its name."""
    return type(law)(law.__name__, (law,), {}, name=name, **row)  # type: ignore[call-overload,no-any-return]


def effects_of(*modules: ModuleType) -> dict[str, type[Hidden]]:
    """Return all effects by name: the rows of ``effects.toml`` beside the first of the modules.

    A row's ``law`` is the name of the class, if it is not the effect's own; the first module that
    has it counts.
    """
    laws = {
        law.name: law
        for module in reversed(modules)
        for law in vars(module).values()
        if isinstance(law, type) and issubclass(law, Hidden) and law is not Hidden
    }
    table = Path(str(modules[0].__file__)).with_name("effects.toml").read_text(encoding="utf-8")
    return {
        name: variant(laws[row.pop("law", name)], name, **row)
        for name, row in tomllib.loads(table).items()
    }


def make_from(
    known: Mapping[str, type[Hidden]],
    name: str,
    size: str | float,
    rng: np.random.Generator,
    channel: str = "",
) -> Hidden:
    """Return an effect with a size by name (weak, medium, strong, within 15 %) or in its own unit.

    Parameters
    ----------
    known : mapping of str to type
        All effects.
    name : str
    size : str or float
    rng : Generator
        For its random numbers.
    channel : str
        The sensor of an effect that acts on one; drawn if not given.
    """
    kind = known[name]
    spread = float(np.exp(rng.uniform(-0.15, 0.15)))
    if isinstance(size, str):
        size = kind.sizes[SIZES.index(size)] * spread
    drawn = str(rng.choice(kind.channels)) if kind.channels else ""
    return kind(size, rng, channel or drawn)
