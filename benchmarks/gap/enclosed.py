"""Effects common to the belt-driven spindle and the lathe, which both have an enclosure."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import ClassVar

import numpy as np

from benchmarks.gap.drive import Array
from benchmarks.gap.hidden import Hidden
from benchmarks.gap.march import Now


class SurfaceExchange(Hidden, ABC, named=False):
    """Heat exchange of surfaces beyond their constant films; a machine defines the surfaces."""

    @abstractmethod
    def flux(self, own: Array, around: Array | float) -> Array:
        """Return the heat into surfaces [W/m2] from their and the air's temperatures [degC]."""


class NaturalConvection(SurfaceExchange):
    """Buoyancy: h = c |dT|^(1/3), as on large surfaces."""

    unit: ClassVar[str] = "W/(m2 K^1.33)"
    sizes: ClassVar[tuple[float, float, float]] = (0.8, 2.0, 4.0)

    def flux(self, own: Array, around: Array | float) -> Array:
        """Return the heat into surfaces [W/m2]."""
        return np.asarray(self.size * np.cbrt(np.abs(around - own)) * (around - own))


class Radiation(SurfaceExchange):
    """Grey surfaces; walls have the temperature of the air in front of them."""

    unit: ClassVar[str] = "1"
    sizes: ClassVar[tuple[float, float, float]] = (0.25, 0.5, 0.85)

    def flux(self, own: Array, around: Array | float) -> Array:
        """Return the heat into surfaces [W/m2]."""
        beyond = (around + 273.15) ** 4 - (own + 273.15) ** 4
        return np.asarray(self.size * 5.670374e-8 * beyond)


class DoorOpen(Hidden):
    """The door is periodically open for a while and exchanges the air inside.

    The size is the exchange with the hall while it is open [W/K].
    """

    unit: ClassVar[str] = "W/K"
    sizes: ClassVar[tuple[float, float, float]] = (40.0, 120.0, 400.0)
    catalogued: ClassVar[bool] = False

    def heat(self, now: Now, out: Array) -> None:
        """Let hall air in."""
        open_now = (now.time / 3600.0 + 0.5) % self.more["every_h"] < self.more["open_h"]
        if now.time > 0.0 and open_now:
            air = int(now.machine.parts["air"][0])
            out[air] += self.size * (now.hall - float(now.temperature[air]))


class SteadySource(Hidden, named=False):
    """A heat source that is on from the start of a run to its end."""

    unit: ClassVar[str] = "W"
    part: ClassVar[str]
    cells: ClassVar[slice] = slice(None)

    def heat(self, now: Now, out: Array) -> None:
        """Warm the part."""
        cells = now.machine.parts[self.part][self.cells]
        out[cells] += (self.size if now.time > 0.0 else 0.0) / len(cells)
