"""Effects of belt and motor, of turning parts and of cutting."""

from __future__ import annotations

from typing import ClassVar

import numpy as np

from benchmarks.gap.belt.drive import REST, Drive
from benchmarks.gap.belt.machine import POSE, TOP_SPEED, Machine
from benchmarks.gap.belt.march import Now
from benchmarks.gap.enclosed import Array, Hidden


class MotorIronLoss(Hidden):
    """The motor on the headstock loses more with speed and its square; watts at 8,000 r/min."""

    name: ClassVar[str] = "motor_iron_loss"
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

    name: ClassVar[str] = "copper_loss"
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

    name: ClassVar[str] = "windage"
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

    name: ClassVar[str] = "cutting_heat"
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


class ToolHeating(Hidden):
    """A holder from the magazine takes heat from the nose, and grows.

    The size is the conductance of its seat [W/K].
    """

    name: ClassVar[str] = "tool_heating"
    unit: ClassVar[str] = "W/K"
    sizes: ClassVar[tuple[float, float, float]] = (0.8, 2.5, 7.0)

    def draw(self, rng: np.random.Generator) -> None:
        """Choose mass, length and what it loses to the air."""
        self.more["capacity_J_K"] = float(rng.uniform(700.0, 2200.0))
        self.more["length_mm"] = float(rng.uniform(60.0, 150.0))
        self.more["loss_W_K"] = float(rng.uniform(0.3, 1.5))

    def begin(self, machine: Machine, drive: Drive) -> None:
        """Take a holder as warm as the hall when the run begins."""
        self._mounted = drive.family != REST
        nodes, share = machine.shaft.face(machine.drawing.gauge_line)
        self._nose, self._share = machine.parts["shaft"][nodes], share
        self._holder = float(np.interp(drive.time_s[0], drive.grid_s, drive.outside[:, 0]))
        self._times, self._values = [float(drive.time_s[0])], [self._holder]

    def _warm(self, now: Now) -> float:
        return float(now.temperature[self._nose] @ self._share)

    def heat(self, now: Now, out: Array) -> None:
        """Take heat from the nose."""
        if self._mounted:
            out[self._nose] -= self.size * (self._warm(now) - self._holder) * self._share

    def advance(self, now: Now, step: float) -> None:
        """Warm the holder, exactly for a nose and air that stay."""
        if not self._mounted:
            return
        whole = self.size + self.more["loss_W_K"]
        end = (self.size * self._warm(now) + self.more["loss_W_K"] * now.hall) / whole
        decay = float(np.exp(-step * whole / self.more["capacity_J_K"]))
        self._holder = end + decay * (self._holder - end)
        self._times.append(now.time)
        self._values.append(self._holder)

    def move(self, machine: Machine, drive: Drive, temperatures: Array, pose: Array) -> None:
        """Add the holder's growth; with no seat there is no holder."""
        if self.size > 0.0:
            warm = np.interp(drive.time_s, self._times, self._values) - self._values[0]
            grown = machine.p["alpha_steel"] * 1e-3 * self.more["length_mm"] * warm
            pose[:, POSE.index("elongation")] += grown
