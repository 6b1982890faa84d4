"""A conductance that rises with speed or feed: for example, a moving axis cools its nut.

The path at rest is unchanged; motion adds a separate link. A recorded flow or flag also counts as
motion: flood coolant, or a door that lets in the hall's air.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from typing import ClassVar, Self

from gap_finder.added_paths import AddedPath
from gap_finder.kinds.base import CalibratedRun, PathChange, recorded, with_item
from plant_model.machine import Item, Machine

MOTIONS = ("rpm", "mm_min", "lpm", "1")
"""Units of inputs that may drive it: speed, feed, flow, and a flag such as an open door."""


@dataclass(frozen=True)
class ConductanceWithMotion(PathChange):
    """A path with a higher conductance while an input moves."""

    title: ClassVar[str] = "Conductance that rises with motion"

    @classmethod
    def all_of(cls, runs: Sequence[CalibratedRun]) -> Iterator[Self]:
        """Yield every path, and every part with every boundary, with each motion."""
        machine = runs[0].machine
        moving = [entry.name for entry in recorded(runs) if entry.unit in MOTIONS]
        kinds = ("conduction", "contact", "convection")
        pairs = [item.refs["between"] for item in machine.of_kind("links", *kinds)]
        pairs += [
            (node.name, outside) for node in machine.nodes for outside in machine.boundary_index
        ]
        for pair, driver in product(dict.fromkeys(pairs), moving):
            yield cls((*pair, driver))

    def path(self) -> AddedPath:
        """Return the path that motion adds."""
        return AddedPath(self.place[:2], self.sizes(), self.place[2])

    @property
    def made(self) -> str:
        """Name of the link."""
        return f"{self.place[0]}-{self.place[1]}-moved_by_{self.place[2]}"

    def parameters(self) -> dict[str, str]:
        """Return the conductance added at the top of the input's range."""
        return {self.amplitude: f"links.{self.made}.conductance"}

    def put_into(self, machine: Machine, numbers: Mapping[str, float]) -> Machine:
        """Return the machine with this link."""
        g = self.free(numbers, self.amplitude, "W/K")
        refs = {"between": self.place[:2], "driven_by": self.place[2:]}
        item = Item("links", self.made, "stirred", refs, {"conductance": g})
        return with_item(machine, item, "stirred_film")
