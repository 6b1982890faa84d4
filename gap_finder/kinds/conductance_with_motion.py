"""A conductance that rises with speed or feed: for example, a moving axis cools its nut.

The path at rest is unchanged; motion adds a separate link. A recorded flow or flag also counts as
motion: flood coolant, or a door that lets in the hall's air.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import ClassVar, Self

from gap_finder.added_paths import AddedPath
from gap_finder.kinds.base import CalibratedRun, PathChange, free, recorded, with_item
from plant_model.machine import Item, Machine

MOTIONS = ("rpm", "mm_min", "lpm", "1")
"""Units of inputs that may drive it: speed, feed, flow, and a flag such as an open door."""


@dataclass(frozen=True)
class ConductanceWithMotion(PathChange):
    """A path with a higher conductance while an input moves."""

    name: ClassVar[str] = "conductance_with_motion"
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
        names = {item.name for item in machine.items}
        for pair in dict.fromkeys(pairs):
            for driver in moving:
                change = cls((*pair, driver))
                if change._name not in names:
                    yield change

    def path(self) -> AddedPath:
        """Return the path that motion adds."""
        return AddedPath(self.place[:2], self.sizes(), self.place[2])

    @property
    def _name(self) -> str:
        return f"{self.place[0]}-{self.place[1]}-moved_by_{self.place[2]}"

    def parameters(self) -> dict[str, str]:
        """Return the conductance added at the top of the input's range."""
        return {self.amplitude: f"links.{self._name}.conductance"}

    def put_into(self, machine: Machine, numbers: Mapping[str, float]) -> Machine:
        """Return the machine with this link."""
        g = free(numbers[self.amplitude], "W/K", self.possible(self.amplitude))
        refs = {"between": self.place[:2], "driven_by": self.place[2:]}
        item = Item("links", self._name, "stirred", refs, {"conductance": g})
        return with_item(machine, item, "stirred_film")
