"""A part that is one lump and should be two: it has two time constants instead of one.

Half of its mass and of its surface becomes a far side. Heat enters on the near side; its
thermometers, its links to other parts, or both are on the far side. If thermometers on one part
disagree, one of them is on the far side.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import ClassVar, Self

from gap_finder.kinds.base import CalibratedRun, Change, conductance_of, joinable, joined, with_item
from gap_finder.reference import LAGS_MIN
from plant_model.machine import Item, Machine, Node
from plant_model.parameters import Parameter


@dataclass(frozen=True)
class CoarsePart(Change):
    """A part split in two.

    Attributes
    ----------
    capacity : float
        Of the whole part [J/K].
    sensors : tuple of str
        Thermometers on the far side.
    links : bool
        Whether its links are also on the far side.
    """

    title: ClassVar[str] = "Part that is one lump and should be two"
    amplitude: ClassVar[str] = "conductance"
    at_once: ClassVar[int] = 1

    capacity: float
    sensors: tuple[str, ...]
    links: bool

    @classmethod
    def all_of(cls, runs: Sequence[CalibratedRun]) -> Iterator[Self]:
        """Yield every part, split in each way that may be visible."""
        machine = runs[0].machine
        others = joinable(machine)
        for node in machine.nodes:
            # Cells of a drawn body are already as small as their conduction requires.
            if node.capacity.tied or node.name not in others:
                continue
            sensors = tuple(sensor.name for sensor in machine.sensors if sensor.of == node.name)
            single = [(name,) for name in sensors] if len(sensors) > 1 else []
            heated = any(
                node.name in names
                for item in machine.items
                if item.family == "sources"
                for names in item.refs.values()
            )
            for moved in dict.fromkeys([*single, sensors, ()]):
                for links in (False, True) if heated else (False,):
                    if moved or links:
                        yield cls((node.name,), node.capacity.value, moved, links)

    @property
    def made(self) -> str:
        """Name of the far side."""
        return f"{self.place[0]}_far"

    def points(self) -> list[dict[str, float]]:
        """Return conductances for a few delays of the far side."""
        return [{self.amplitude: self.capacity / 2.0 / (60.0 * delay)} for delay in LAGS_MIN]

    def parameters(self) -> dict[str, str]:
        """Return the conductance between the sides."""
        return {self.amplitude: conductance_of((self.place[0], self.made), boundary=False)}

    def scaled(self, numbers: Mapping[str, float], scale: float) -> dict[str, float]:
        """Return the conductance for a delay of the far side multiplied by *scale*."""
        return {self.amplitude: numbers[self.amplitude] / scale}

    def put_into(self, machine: Machine, numbers: Mapping[str, float]) -> Machine:
        """Return the machine with the part split in two."""
        name = self.place[0]
        nodes = []
        for node in machine.nodes:
            if node.name == name:
                nodes.append(replace(node, capacity=_half(node.capacity)))
                far = Node(self.made, _half(node.capacity), node.start, node.start_share)
            else:
                nodes.append(node)
        sensors = tuple(
            replace(sensor, of=self.made) if sensor.name in self.sensors else sensor
            for sensor in machine.sensors
        )
        items = tuple(self._near(item) for item in machine.items)
        grown = replace(machine, nodes=(*nodes, far), sensors=sensors, items=items)
        for item in items:
            if self._is_surface(item):
                other = replace(self._on_far_side(item), name=f"{item.name}_far")
                grown = with_item(grown, other, "surface_convection")
        path = self.free(numbers, self.amplitude, "W/K")
        return joined(grown, (name, self.made), path)

    def _near(self, item: Item) -> Item:
        """Return an item after the split: surfaces are halved, other links may move."""
        if self._is_surface(item):
            half = {**item.parameters, "area": _half(item.parameters["area"])}
            return replace(item, parameters=half)
        return self._on_far_side(item) if self.links else item

    def _is_surface(self, item: Item) -> bool:
        return item.kind == "convection" and self.place[0] in item.refs["between"]

    def _on_far_side(self, item: Item) -> Item:
        """Return a link of the part moved to its far side, with the same name."""
        pair = item.refs.get("between", ())
        if item.family != "links" or self.place[0] not in pair:
            return item
        moved = tuple(self.made if part == self.place[0] else part for part in pair)
        return replace(item, refs={**item.refs, "between": moved})


def _half(whole: Parameter) -> Parameter:
    if whole.tied:
        return replace(whole, factor=whole.factor / 2.0).following(whole.value / whole.factor)
    return replace(whole, value=whole.value / 2.0, low=whole.low / 2.0, high=whole.high / 2.0)
