"""Effects of belt and motor, of turning parts and of cutting."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar

import numpy as np

from benchmarks.gap import hidden
from benchmarks.gap.belt.machine import TOP_SPEED, Machine
from benchmarks.gap.drive import Array, Drive
from benchmarks.gap.hidden import Hidden
from benchmarks.gap.march import Now


class MotorIronLoss(Hidden):
    """The motor on the headstock loses more with speed and its square; watts at 8,000 r/min."""

    unit: ClassVar[str] = "W"
    sizes: ClassVar[tuple[float, float, float]] = (50.0, 130.0, 400.0)

    def begin(self, machine: Machine, drive: Drive) -> None:
        """Hardly any of it takes the way through the belt."""
        self._entry = machine.drive_entry(0.1)

    def heat(self, now: Now, out: Array) -> None:
        """Add a quarter in proportion to speed, the rest to its square."""
        n = now.speed / TOP_SPEED
        out += self.size * (0.25 * n + 0.75 * n**2) * self._entry


class CopperLoss(Hidden):
    """The motor's winding warms the headstock under load; watts at 20 Nm."""

    unit: ClassVar[str] = "W"
    sizes: ClassVar[tuple[float, float, float]] = (100.0, 300.0, 900.0)

    def begin(self, machine: Machine, drive: Drive) -> None:
        """It all goes to the headstock."""
        self._entry = machine.drive_entry(0.0)

    def heat(self, now: Now, out: Array) -> None:
        """Add the loss at this torque."""
        if now.torque:
            warm = 1.0 + 0.0039 * (now.mean("headstock") - 20.0)
            out += self.size * (now.torque / 20.0) ** 2 * warm * self._entry


class Windage(Hidden):
    """Air friction on shaft and nose, k n^3; watts at 8,000 r/min."""

    unit: ClassVar[str] = "W"
    sizes: ClassVar[tuple[float, float, float]] = (15.0, 50.0, 150.0)

    def begin(self, machine: Machine, drive: Drive) -> None:
        """Half of it warms the shaft between the bearings, half the housing around it."""
        d = machine.drawing
        self._entry = np.zeros(len(machine.capacity))
        for solid, part, side in (
            (machine.shaft, "shaft", "outer"),
            (machine.housing, "housing", "inner"),
        ):
            nodes, area = solid.surface(side, d.rear[0][1], d.front[0][0])
            self._entry[machine.parts[part][nodes]] += 0.5 * area / area.sum()

    def heat(self, now: Now, out: Array) -> None:
        """Add the loss at this speed."""
        out += self.size * (now.speed / TOP_SPEED) ** 3 * self._entry


class CuttingHeat(Hidden):
    """A share of the cutting power goes into tool and nose; the size is that share."""

    unit: ClassVar[str] = "1"
    sizes: ClassVar[tuple[float, float, float]] = (0.005, 0.02, 0.06)

    def begin(self, machine: Machine, drive: Drive) -> None:
        """Most of it into the tool's tip, some into the nose."""
        self._entry = np.zeros(len(machine.capacity))
        d = machine.drawing
        tip, share = machine.tool.face(d.gauge_line + d.tool_length)
        self._entry[machine.parts["tool"][tip]] += 0.6 * share
        nose, share = machine.shaft.face(d.gauge_line)
        self._entry[machine.parts["shaft"][nose]] += 0.4 * share

    def heat(self, now: Now, out: Array) -> None:
        """Add the share of torque times speed."""
        if now.torque:
            out += self.size * now.torque * now.speed * np.pi / 30.0 * self._entry


class ToolHeating(hidden.ToolHeating):
    """It sits on the shaft's end."""

    drawn: ClassVar[Mapping[str, tuple[float, float]]] = {
        "capacity_J_K": (700.0, 2200.0),
        "length_mm": (60.0, 150.0),
        "loss_W_K": (0.3, 1.5),
    }

    def seat(self, machine: Machine) -> tuple[Any, Array]:
        """Return the nodes of the shaft's face."""
        nodes, share = machine.shaft.face(machine.drawing.gauge_line)
        return machine.parts["shaft"][nodes], share
