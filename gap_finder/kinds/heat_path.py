"""Heat paths missing in the machine file: between two parts, or from a part to the air."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations, product
from typing import ClassVar, Self

from gap_finder.added_paths import AddedPath
from gap_finder.kinds.base import CalibratedRun, PathChange, conductance_of, joinable, joined
from plant_model.machine import Machine


@dataclass(frozen=True)
class HeatPath(PathChange):
    """A heat path between a part and another part or a boundary temperature."""

    title: ClassVar[str] = "Heat path that the machine file does not have"

    place: tuple[str, str]
    boundary: bool

    @classmethod
    def all_of(cls, runs: Sequence[CalibratedRun]) -> Iterator[Self]:
        """Yield the paths that the machine does not have."""
        machine = runs[0].machine
        there = {frozenset(item.refs.get("between", ())) for item in machine.items}
        nodes = [node.name for node in machine.nodes]
        pairs = [*combinations(nodes, 2), *product(nodes, machine.boundary_index)]
        others = joinable(machine)
        for pair in pairs:
            if frozenset(pair) not in there and pair[1] in others:
                yield cls(pair, pair[1] in machine.boundary_index)

    @property
    def made(self) -> str:
        """Name of the link."""
        return "-".join(self.place)

    def path(self) -> AddedPath:
        """Return the path between its two ends."""
        return AddedPath(self.place, self.sizes())

    def parameters(self) -> dict[str, str]:
        """Return the conductance; for a surface, the coefficient on 1 m2."""
        return {self.amplitude: conductance_of(self.place, boundary=self.boundary)}

    def put_into(self, machine: Machine, numbers: Mapping[str, float]) -> Machine:
        """Return the machine with this path."""
        return joined(machine, self.place, self.free(numbers, self.amplitude, "W/K"))
