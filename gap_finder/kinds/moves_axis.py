"""A part that moves an axis without the machine file saying so."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import ClassVar, Self

import numpy as np

from gap_finder.kinds.base import CalibratedRun, Change, fixed, with_item
from plant_model.machine import Item, Machine
from plant_model.parameters import FloatArray
from plant_model.sensors import displacement_names

SIZES_MM = (60.0, 600.0)
"""Usual lengths of a part, which are tried: the response is proportional to them [mm]. Set on no
data."""

EXPANSION = 11.0
"""Given by steel and cast iron, between 10 and 12 [1e-6/K]."""

AXES = {"X": "x", "Y": "y", "Z": "elongation"}
"""Axes, and their names in a structure."""


@dataclass(frozen=True)
class MovesAxis(Change):
    """A part whose growth moves one axis, in either direction."""

    title: ClassVar[str] = "Part that moves an axis"
    amplitude: ClassVar[str] = "length"

    way: float

    @classmethod
    def all_of(cls, runs: Sequence[CalibratedRun]) -> Iterator[Self]:
        """Yield every part with every measured axis, in either direction.

        Pairs already in the structure are left out: their length is calibrated there, or was drawn.
        """
        machine = runs[0].machine
        if "thermal_expansion" not in machine.effects:
            return
        there = {
            (item.refs["nodes"], name)
            for item in machine.of_kind("structure", "member")
            for name in AXES.values()
            if item.parameters[name].value
        }
        for node in machine.nodes:
            for axis in _measured(runs[0]):
                if ((node.name,), AXES[axis]) not in there:
                    yield from (cls((node.name, axis), way) for way in (-1.0, 1.0))

    @property
    def made(self) -> str:
        """Name of the member."""
        return f"{self.place[0]}_moves_{self.place[1]}{'_back' if self.way < 0.0 else ''}"

    def points(self) -> list[dict[str, float]]:
        """Return a short and a long part."""
        return [{self.amplitude: size} for size in SIZES_MM]

    def simulated(self) -> tuple[list[dict[str, float]], FloatArray]:
        """Return the short part: responses are proportional to the length."""
        return self.points()[:1], np.array(SIZES_MM)[:, None] / SIZES_MM[0]

    def parameters(self) -> dict[str, str]:
        """Return the length that would move the axis by the same amount."""
        return {self.amplitude: f"structure.{self.made}.length"}

    def put_into(self, machine: Machine, numbers: Mapping[str, float]) -> Machine:
        """Return the machine with this part in the structure."""
        ways = {name: fixed(0.0, "1") for name in AXES.values()}
        ways[AXES[self.place[1]]] = fixed(self.way, "1")
        given = {
            "length": self.free(numbers, self.amplitude, "mm"),
            "expansion": fixed(EXPANSION, "1e-6/K"),
            **ways,
        }
        item = Item("structure", self.made, "member", {"nodes": self.place[:1]}, given)
        return with_item(machine, item, "thermal_expansion")


def _measured(run: CalibratedRun) -> list[str]:
    """Return the axes measured by a compared displacement."""
    rig, channels = run.machine.rig, run.observed.channels
    if rig["kind"] == "direct":
        return sorted({probe["axis"] for name, probe in rig["axes"].items() if name in channels})
    names = displacement_names(run.machine)
    shown = zip(("X", "Y", "X", "Y", "Z"), names, strict=True)
    return sorted({axis for axis, name in shown if name in channels})
