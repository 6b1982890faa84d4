"""Heat sources missing in the machine file: in a part, constant or driven by an input."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from itertools import product
from typing import ClassVar, Self

import numpy as np

from gap_finder.kinds.base import CalibratedRun, Change, recorded, with_item
from plant_model.effects.plain_heat import PlainHeat
from plant_model.machine import Item, Machine
from plant_model.parameters import FloatArray

SIZES_W = (20.0, 200.0)
"""Usual powers, which are tried: the response is proportional to them [W]. Set on no data."""

DRIVEN = "driven_heat"
EXPONENT = PlainHeat.handles["sources", DRIVEN].numbers["exponent"]
"""Of an input: friction has 1, viscous drag 5/3 or 2, windage 3."""

EXPONENTS = np.arange(EXPONENT.low, EXPONENT.high + 0.125, 0.25)
"""Those that are tried. Set on the twenty-seventh split, lathe 0021: a source with exponent 1
explains nothing of left-out runs if it is screened at 0.8 or 1.2."""

SIMULATED = np.geomspace(EXPONENT.low, EXPONENT.high, 3)
"""Those that are simulated: the others' powers are sums of these, to 2 % of the input's range."""


@cache
def _shares() -> FloatArray:
    """Return the shares of the simulated powers in each that is tried, (tried, simulated)."""
    of_range = np.linspace(0.0, 1.0, 101)[:, None]
    powers = np.linalg.lstsq(of_range**SIMULATED, of_range**EXPONENTS, rcond=None)[0]
    return np.asarray(powers.T)


@dataclass(frozen=True)
class HeatSource(Change):
    """A heat source in a part."""

    title: ClassVar[str] = "Heat source that the machine file does not have"
    amplitude: ClassVar[str] = "power"
    only_heats: ClassVar[bool] = True

    @classmethod
    def all_of(cls, runs: Sequence[CalibratedRun]) -> Iterator[Self]:
        """Yield a source for every part, constant or driven by each recorded input.

        An input that already heats the part may heat it by another exponent, too.
        """
        machine = runs[0].machine
        driving = [(entry.name,) for entry in recorded(runs)]
        for node in machine.nodes:
            yield from (cls((node.name, *driver)) for driver in ((), *driving))

    @property
    def made(self) -> str:
        """Name of the source."""
        return "heat_in_" + "_by_".join(self.place)

    def points(self) -> list[dict[str, float]]:
        """Return a small and a large power, each at all exponents if an input drives it."""
        if len(self.place) == 1:
            return [{self.amplitude: size} for size in SIZES_W]
        exponents = EXPONENTS.tolist()
        return [{self.amplitude: w, "exponent": a} for w, a in product(SIZES_W, exponents)]

    def simulated(self) -> tuple[list[dict[str, float]], FloatArray]:
        """Return the small power, at three exponents if an input drives it."""
        sizes = np.array(SIZES_W)[:, None] / SIZES_W[0]
        if len(self.place) == 1:
            return self.points()[:1], sizes
        points = [{self.amplitude: SIZES_W[0], "exponent": a} for a in SIMULATED.tolist()]
        return points, np.kron(sizes, _shares()).astype(np.float64)

    def usual(self, number: str) -> tuple[float, float]:
        """Return the usual range of the power, or all exponents that a file may have."""
        return (EXPONENT.low, EXPONENT.high) if number == "exponent" else super().usual(number)

    def possible(self, number: str) -> tuple[float, float]:
        """Return the range of the prior of the power or the exponent."""
        return self.usual(number) if number == "exponent" else super().possible(number)

    def parameters(self) -> dict[str, str]:
        """Return the power, at the top of the input's range if one drives it, and the exponent."""
        return {number: f"sources.{self.made}.{number}" for number in self.points()[0]}

    def put_into(self, machine: Machine, numbers: Mapping[str, float]) -> Machine:
        """Return the machine with this source."""
        refs, kind = {"node": self.place[:1]}, "steady_heat"
        if len(self.place) > 1:
            refs["driven_by"], kind = self.place[1:], DRIVEN
        forms = PlainHeat.handles["sources", kind].numbers
        given = {number: self.free(numbers, number, forms[number].unit) for number in numbers}
        return with_item(machine, Item("sources", self.made, kind, refs, given), "plain_heat")
