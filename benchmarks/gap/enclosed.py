"""What can be hidden in the belt-driven spindle and in the lathe, which both stand in an enclosure.

The jig borer's simulator shares none of it: it stays a judge that has no mistakes in common with
these.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import TYPE_CHECKING, ClassVar

import numpy as np
import pandas as pd
from numpy.typing import NDArray

if TYPE_CHECKING:
    from benchmarks.gap.belt.drive import Drive
    from benchmarks.gap.belt.machine import Machine
    from benchmarks.gap.belt.march import Now

Array = NDArray[np.float64]


class Hidden:
    """Base of everything that can be hidden; nothing happens by default.

    Attributes
    ----------
    size : float
        Its amplitude; at 0 the effect vanishes.
    channel : str
        The sensor that it acts on, if it acts on one.
    """

    name: ClassVar[str]
    unit: ClassVar[str]
    sizes: ClassVar[tuple[float, float, float]]
    """Amplitudes called weak, medium and strong."""
    channels: ClassVar[tuple[str, ...]] = ()
    catalogued: ClassVar[bool] = True
    in_other_words: ClassVar[tuple[tuple[str, tuple[str, ...]], ...]] = ()
    """Changes of the machine's file, kind and place, that say the same; ``*`` is any part."""

    def __init__(self, size: float, rng: np.random.Generator, channel: str = "") -> None:
        self.size, self.channel = float(size), channel
        self.more: dict[str, float] = {}
        """Its other numbers, for the answers file."""
        self.draw(rng)

    def draw(self, rng: np.random.Generator) -> None:
        """Choose the numbers besides the size."""

    def begin(self, machine: Machine, drive: Drive) -> None:
        """Forget the run before."""

    def friction(self, now: Now, viscous: Array, load: Array) -> tuple[Array, Array]:
        """Return the heat of the front and the rear set [W], changed."""
        return viscous, load

    def heat(self, now: Now, out: Array) -> None:
        """Add heat [W]."""

    def scales(self, now: Now) -> dict[str, float]:
        """Return factors on groups of conductances."""
        return {}

    def advance(self, now: Now, step: float) -> None:
        """Step the effect's own states."""

    def move(self, machine: Machine, drive: Drive, temperatures: Array, pose: Array) -> None:
        """Change the pose in place, shape (rows, 3); temperatures are (rows, unknowns)."""

    def record(self, number: int, machine: Machine, drive: Drive, shown: pd.DataFrame) -> None:
        """Change what the sensors show, in place; *number* counts the case's runs from 0."""


class SurfaceExchange(Hidden, ABC):
    """Exchange of surfaces beyond their constant films; a machine says which surfaces."""

    @abstractmethod
    def flux(self, own: Array, around: Array | float) -> Array:
        """Return what surfaces gain [W/m2], from their own and the air's temperatures [degC]."""


class NaturalConvection(SurfaceExchange):
    """Buoyancy: h = c |dT|^(1/3), as on large surfaces."""

    name: ClassVar[str] = "natural_convection"
    unit: ClassVar[str] = "W/(m2 K^1.33)"
    sizes: ClassVar[tuple[float, float, float]] = (0.8, 2.0, 4.0)

    def flux(self, own: Array, around: Array | float) -> Array:
        """Return what surfaces gain [W/m2]."""
        return np.asarray(self.size * np.cbrt(np.abs(around - own)) * (around - own))


class Radiation(SurfaceExchange):
    """Grey surfaces; walls have the temperature of the air in front of them."""

    name: ClassVar[str] = "radiation"
    unit: ClassVar[str] = "1"
    sizes: ClassVar[tuple[float, float, float]] = (0.25, 0.5, 0.85)

    def flux(self, own: Array, around: Array | float) -> Array:
        """Return what surfaces gain [W/m2]."""
        beyond = (around + 273.15) ** 4 - (own + 273.15) ** 4
        return np.asarray(self.size * 5.670374e-8 * beyond)


class DoorOpen(Hidden):
    """The door stands open for a while in every cycle of its own, and the air inside goes out.

    The size is the exchange with the hall while it does [W/K].
    """

    name: ClassVar[str] = "door_open"
    unit: ClassVar[str] = "W/K"
    sizes: ClassVar[tuple[float, float, float]] = (40.0, 120.0, 400.0)
    catalogued: ClassVar[bool] = False
    every_h: ClassVar[tuple[float, float]]
    """Shortest and longest cycle [h]."""

    def draw(self, rng: np.random.Generator) -> None:
        """Choose when."""
        self.more["every_h"] = float(rng.uniform(*self.every_h))
        self.more["open_h"] = float(rng.uniform(0.3, 0.7))

    def heat(self, now: Now, out: Array) -> None:
        """Let hall air in."""
        open_now = (now.time / 3600.0 + 0.5) % self.more["every_h"] < self.more["open_h"]
        if now.time > 0.0 and open_now:
            air = int(now.machine.parts["air"][0])
            out[air] += self.size * (now.hall - float(now.temperature[air]))
