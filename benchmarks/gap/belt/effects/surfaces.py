"""Effects on surfaces in the air of the enclosure and of the hall."""

from __future__ import annotations

from typing import ClassVar

import numpy as np

from benchmarks.gap import enclosed
from benchmarks.gap.belt.machine import TOP_SPEED, Machine
from benchmarks.gap.drive import Array, Drive
from benchmarks.gap.hidden import Hidden
from benchmarks.gap.march import Now


class ForcedConvection(Hidden):
    """The turning spindle stirs the air inside: h = h0 (1 + c (n / 8,000)^0.7).

    The walls of the enclosure share in it by a third, the column outside does not.
    """

    unit: ClassVar[str] = "1"
    sizes: ClassVar[tuple[float, float, float]] = (0.5, 1.5, 4.0)
    in_other_words = (("conductance_with_motion", ("*", "enclosure_air", "speed")),)

    def scales(self, now: Now) -> dict[str, float]:
        """Return the factors at this speed."""
        wind = self.size * (now.speed / TOP_SPEED) ** 0.7
        inside = dict.fromkeys(("film_housing", "film_headstock"), 1.0 + wind)
        return inside | {"film_walls": 1.0 + wind / 3.0}


class _Surface(enclosed.SurfaceExchange, named=False):
    """Exchange beyond the constant film; surfaces inside face the air there, others the hall."""

    def begin(self, machine: Machine, drive: Drive) -> None:
        """Collect the areas."""
        d, parts = machine.drawing, machine.parts
        low, high = d.housing[0].start, d.housing[-1].end
        numbers, areas, self._inside = [], [], []
        for start, end in ((low, d.clamp[0]), (d.clamp[1], high)):
            nodes, area = machine.housing.surface("outer", start, end)
            numbers.append(parts["housing"][nodes])
            areas.append(area)
            self._inside += [True] * len(nodes)
        for name, body in d.bodies.items():
            cells = parts[name]
            numbers.append(cells)
            areas.append(np.full(len(cells), body.surface / len(cells)))
            self._inside += [name in ("headstock", "z_nut")] * len(cells)
        self._numbers, self._areas = np.concatenate(numbers), np.concatenate(areas)
        self._air = int(parts["air"][0])

    def heat(self, now: Now, out: Array) -> None:
        """Add what the surfaces gain; the air inside has what those inside lose."""
        own = now.temperature[self._numbers]
        air = float(now.temperature[self._air])
        around = np.where(self._inside, air, now.hall)
        gained = self._areas * self.flux(own, around)
        np.add.at(out, self._numbers, gained)
        out[self._air] -= float(gained[self._inside].sum())


class NaturalConvection(enclosed.NaturalConvection, _Surface):
    """Buoyancy on all surfaces."""


class Radiation(enclosed.Radiation, _Surface):
    """All surfaces are grey."""
