"""A mass behind a part, missing in the machine file: something bolted on that follows slowly."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import product
from typing import ClassVar, Self

from gap_finder.added_paths import AddedPath
from gap_finder.kinds.base import CalibratedRun, PathChange, conductance_of, joinable, joined
from gap_finder.reference import LAGS_MIN
from plant_model.machine import Machine, Node

MASSES = (0.5, 2.0)
"""Heat capacities tried, as multiples of the part's [1]; set on no data."""


@dataclass(frozen=True)
class HiddenMass(PathChange):
    """A mass behind a part; it exchanges heat only with that part and starts at its temperature."""

    title: ClassVar[str] = "Mass behind a part that the machine file does not have"

    capacity: float

    @classmethod
    def all_of(cls, runs: Sequence[CalibratedRun]) -> Iterator[Self]:
        """Yield a mass for every part."""
        machine = runs[0].machine
        others = joinable(machine)
        parts = (node for node in machine.nodes if node.name in others)
        yield from (cls((part.name,), part.capacity.value) for part in parts)

    def path(self) -> AddedPath:
        """Return the path from the part to the mass."""
        masses = tuple(point["capacity"] for point in self.points())
        return AddedPath(self.place, self.sizes(), masses=masses)

    @property
    def made(self) -> str:
        """Name of the mass."""
        return f"{self.place[0]}_behind"

    def points(self) -> list[dict[str, float]]:
        """Return a few sizes, each at a few delays."""
        return [
            {
                self.amplitude: mass * self.capacity / (60.0 * delay),
                "capacity": mass * self.capacity,
            }
            for mass, delay in product(MASSES, LAGS_MIN)
        ]

    def parameters(self) -> dict[str, str]:
        """Return its conductance to the part and its heat capacity."""
        return {
            self.amplitude: conductance_of((self.place[0], self.made), boundary=False),
            "capacity": f"nodes.{self.made}.capacity",
        }

    def scaled(self, numbers: Mapping[str, float], scale: float) -> dict[str, float]:
        """Return the numbers of a mass multiplied by *scale* with the same delay."""
        return {name: value * scale for name, value in numbers.items()}

    def put_into(self, machine: Machine, numbers: Mapping[str, float]) -> Machine:
        """Return the machine with this mass."""
        (part,) = (node for node in machine.nodes if node.name == self.place[0])
        mass = self.free(numbers, "capacity", "J/K")
        behind = Node(self.made, mass, part.start, part.start_share)
        grown = replace(machine, nodes=(*machine.nodes, behind))
        path = self.free(numbers, self.amplitude, "W/K")
        return joined(grown, (part.name, self.made), path)
