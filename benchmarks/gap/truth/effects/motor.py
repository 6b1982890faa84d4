"""Effects of motor, turning parts and cutting."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar

import numpy as np

from benchmarks.gap import hidden
from benchmarks.gap.drive import Array, Drive
from benchmarks.gap.hidden import Hidden
from benchmarks.gap.march import Now
from benchmarks.gap.truth.spindle import Spindle


class MotorIronLoss(Hidden):
    """Eddy currents and hysteresis beyond the loss in force; the size is watts at 20,000 r/min."""

    unit: ClassVar[str] = "W"
    sizes: ClassVar[tuple[float, float, float]] = (120.0, 300.0, 600.0)

    def begin(self, spindle: Spindle, drive: Drive) -> None:
        """Iron losses arise in the stator first."""
        self._entry = spindle.motor_entry(0.25)

    def heat(self, now: Now, out: Array) -> None:
        """Add a tenth in proportion to speed, the rest to its square."""
        n = now.speed / 20e3
        out += (self.size * (0.1 * n + 0.9 * n**2)) * self._entry


class Windage(Hidden):
    """Air friction on rotor and shaft, k n^3; the size is watts at 20,000 r/min."""

    unit: ClassVar[str] = "W"
    sizes: ClassVar[tuple[float, float, float]] = (50.0, 110.0, 250.0)

    def begin(self, spindle: Spindle, drive: Drive) -> None:
        """Most of it in the motor's gap, some at the nose."""
        self._entry = 0.85 * spindle.motor_entry(0.5)
        shaft = spindle.parts["shaft"]
        self._entry[shaft] += 0.15 * spindle.layout.share("shaft", 200.0, 400.0)

    def heat(self, now: Now, out: Array) -> None:
        """Add the loss at this speed."""
        out += (self.size * (now.speed / 20e3) ** 3) * self._entry


class CopperLoss(Hidden):
    """I^2 R (1 + 0.0039 dT), current in proportion to torque; the size is watts at 8 Nm."""

    unit: ClassVar[str] = "W"
    sizes: ClassVar[tuple[float, float, float]] = (50.0, 110.0, 250.0)

    def begin(self, spindle: Spindle, drive: Drive) -> None:
        """Slip puts a fifth into the rotor."""
        self._entry = spindle.motor_entry(0.2)
        self._stator = spindle.parts["stator"]

    def heat(self, now: Now, out: Array) -> None:
        """Add the loss at this torque."""
        if now.torque:
            warm = float(now.temperature[self._stator].mean()) - 20.0
            out += self.size * (now.torque / 8.0) ** 2 * (1.0 + 0.0039 * warm) * self._entry


class CuttingHeat(Hidden):
    """A share of the cutting power goes into bar and nose; the size is that share."""

    unit: ClassVar[str] = "1"
    sizes: ClassVar[tuple[float, float, float]] = (0.0008, 0.002, 0.005)

    def begin(self, spindle: Spindle, drive: Drive) -> None:
        """Most of it into the bar, a third into the nose."""
        self._entry = np.zeros(len(spindle.capacity))
        bar = spindle.parts["bar"]
        self._entry[bar] = 0.65 / len(bar)
        self._entry[spindle.parts["shaft"]] += 0.35 * spindle.layout.share("shaft", 340.0, 400.0)

    def heat(self, now: Now, out: Array) -> None:
        """Add the share of torque times speed."""
        if now.torque:
            out += (self.size * now.torque * now.speed * np.pi / 30.0) * self._entry


class ToolHeating(hidden.ToolHeating):
    """It sits on the shaft's last cell."""

    drawn: ClassVar[Mapping[str, tuple[float, float]]] = {
        "capacity_J_K": (600.0, 1800.0),
        "length_mm": (70.0, 140.0),
        "loss_W_K": (0.3, 1.2),
    }

    def seat(self, machine: Spindle) -> tuple[Any, Array]:
        """Return that cell."""
        return machine.parts["shaft"][-1:], np.ones(1)


class EncoderHeat(Hidden):
    """The encoder's electronics at the rear end warm it whenever the control is on."""

    unit: ClassVar[str] = "W"
    sizes: ClassVar[tuple[float, float, float]] = (20.0, 50.0, 100.0)
    catalogued: ClassVar[bool] = False
    in_other_words = (("heat_source", ("housing_rear",)), ("heat_source", ("shaft_rear",)))

    def begin(self, spindle: Spindle, drive: Drive) -> None:
        """It sits at the last cells of housing and shaft."""
        self._entry = np.zeros(len(spindle.capacity))
        sides = spindle.parts["housing"][0]
        self._entry[sides] = 0.7 / len(sides)
        self._entry[spindle.parts["shaft"][0]] = 0.3

    def heat(self, now: Now, out: Array) -> None:
        """Switched on half an hour into the run."""
        if now.time > 1800.0:
            out += self.size * self._entry


class PumpPulses(Hidden):
    """A hydraulic pump at the headstock runs in pulses of its own, and warms it."""

    unit: ClassVar[str] = "W"
    sizes: ClassVar[tuple[float, float, float]] = (40.0, 80.0, 200.0)
    catalogued: ClassVar[bool] = False
    in_other_words = (("heat_source", ("housing_motor_ym",)), ("heat_source", ("pedestal",)))

    drawn: ClassVar[Mapping[str, tuple[float, float]]] = {
        "period_s": (1500.0, 3600.0),
        "on": (0.3, 0.5),
    }

    def heat(self, now: Now, out: Array) -> None:
        """Into the motor housing's Y- side and the headstock."""
        if now.time <= 0.0 or (now.time / self.more["period_s"]) % 1.0 > self.more["on"]:
            return
        parts, layout = now.machine.parts, now.machine.layout
        rows = (layout.middles("housing") > 0.0) & (layout.middles("housing") < 180.0)
        side = parts["housing"][rows][:, 3 * len(layout.angles) // 4]
        out[side] += 0.5 * self.size / len(side)
        out[parts["pedestal"][0]] += 0.5 * self.size
