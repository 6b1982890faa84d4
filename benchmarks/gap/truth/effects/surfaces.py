"""Effects on outer surfaces."""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar

import numpy as np

from benchmarks.gap.drive import Array, Drive
from benchmarks.gap.hidden import Hidden
from benchmarks.gap.march import Now
from benchmarks.gap.truth.cells import AIR, HALL
from benchmarks.gap.truth.spindle import Spindle

REACH = {
    "film_nose": 1.0,
    "film_bar": 1.0,
    "film_housing": 1.0,
    "film_pedestal": 1.0,
    "film_column": 0.6,
}
"""How much of the spindle's wind reaches each surface."""


class ForcedConvection(Hidden):
    """The turning spindle stirs the air: h = h0 (1 + c (n / 20,000)^0.7)."""

    unit: ClassVar[str] = "1"
    sizes: ClassVar[tuple[float, float, float]] = (1.0, 2.0, 4.0)
    in_other_words = (("conductance_with_motion", ("*", "ambient", "speed")),)

    def scales(self, now: Now) -> dict[str, float]:
        """Return the factors at this speed."""
        wind = self.size * (now.speed / 20e3) ** 0.7
        return {group: 1.0 + reach * wind for group, reach in REACH.items()}


class _Surface(Hidden, named=False):
    """Exchange with the air beyond the constant film, by area and temperatures."""

    def begin(self, spindle: Spindle, drive: Drive) -> None:
        """Collect cells, boundaries and areas of all surfaces."""
        films = {
            "film_nose": "h_nose",
            "film_bar": "h_bar",
            "film_housing": "h_housing",
            "film_pedestal": "h_pedestal",
            "film_column": "h_column",
            "film_bed": "h_bed",
        }
        found = [
            (cells, np.full(len(cells), which), g / spindle.p[films[group]])
            for group, parts in spindle.surfaces.items()
            for cells, which, g in parts
        ]
        self._cells = np.concatenate([one[0] for one in found])
        self._which = np.concatenate([one[1] for one in found])
        self._area = np.concatenate([one[2] for one in found])

    def _both(self, now: Now) -> tuple[Array, Array]:
        outside = now.look()[self._which]
        return outside, np.asarray(now.temperature[self._cells])


class NaturalConvection(_Surface):
    """Buoyancy: h = c |dT|^(1/4) on top of the constant film."""

    unit: ClassVar[str] = "W/(m2 K^1.25)"
    sizes: ClassVar[tuple[float, float, float]] = (2.0, 4.0, 8.0)

    def heat(self, now: Now, out: Array) -> None:
        """Add what the surfaces gain."""
        outside, own = self._both(now)
        difference = outside - own
        flux = self.size * np.abs(difference) ** 0.25 * difference
        np.add.at(out, self._cells, self._area * flux)


class Radiation(_Surface):
    """Grey surfaces in a hall whose walls have the air's temperature."""

    unit: ClassVar[str] = "1"
    sizes: ClassVar[tuple[float, float, float]] = (0.3, 0.5, 0.8)

    def heat(self, now: Now, out: Array) -> None:
        """Add what the surfaces gain."""
        outside, own = self._both(now)
        flux = 5.670374e-8 * ((outside + 273.15) ** 4 - (own + 273.15) ** 4)
        np.add.at(out, self._cells, self.size * self._area * flux)


class SunPatch(Hidden):
    """The sun shines on the X+ side of headstock and column for some hours of the day."""

    unit: ClassVar[str] = "W"
    sizes: ClassVar[tuple[float, float, float]] = (80.0, 150.0, 350.0)
    catalogued: ClassVar[bool] = False

    drawn: ClassVar[Mapping[str, tuple[float, float]]] = {
        "from_h": (0.8, 2.5),
        "hours": (1.0, 2.5),
    }

    def heat(self, now: Now, out: Array) -> None:
        """Warm housing (the X+ half), headstock and column."""
        place = (now.time / 3600.0 - self.more["from_h"]) / self.more["hours"]
        if not 0.0 < place < 1.0:
            return
        power = self.size * float(np.sin(np.pi * place))
        parts, layout = now.machine.parts, now.machine.layout
        front = layout.middles("housing") > 180.0
        facing = np.maximum(np.cos(layout.angles), 0.0)
        housing = parts["housing"][front]
        out[housing] += 0.35 * power * facing / facing.sum() / len(housing)
        out[parts["pedestal"]] += 0.35 * power / len(parts["pedestal"])
        out[parts["column"]] += 0.3 * power / len(parts["column"])


class DoorDraft(Hidden):
    """The hall's door opens: air some K colder at the column's foot, which T5 hardly sees."""

    unit: ClassVar[str] = "K"
    sizes: ClassVar[tuple[float, float, float]] = (2.0, 5.0, 10.0)
    catalogued: ClassVar[bool] = False

    drawn: ClassVar[Mapping[str, tuple[float, float]]] = {
        "every_h": (1.5, 3.0),
        "open_h": (0.4, 0.9),
    }

    def boundaries(self, now: Now, values: Array) -> None:
        """Cool the air at column and bed, and a little at the spindle."""
        hour = now.time / 3600.0
        if now.time > 0.0 and (hour + 0.7) % self.more["every_h"] < self.more["open_h"]:
            values[HALL] -= self.size
            values[AIR] -= 0.3 * self.size
