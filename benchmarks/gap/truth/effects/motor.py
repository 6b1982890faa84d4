"""Effects of motor, turning parts and cutting."""

from __future__ import annotations

from typing import ClassVar

import numpy as np

from benchmarks.gap.truth.drive import REST, Drive
from benchmarks.gap.truth.effects.base import Array, Hidden, Now
from benchmarks.gap.truth.spindle import POSE, Spindle


class MotorIronLoss(Hidden):
    """Eddy currents and hysteresis beyond the loss in force; the size is watts at 20,000 r/min."""

    name: ClassVar[str] = "motor_iron_loss"
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

    name: ClassVar[str] = "windage"
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

    name: ClassVar[str] = "copper_loss"
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

    name: ClassVar[str] = "cutting_heat"
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


class ToolHeating(Hidden):
    """A holder at the nose, which carries heat into itself and pushes the bar out as it warms.

    The size is the conductance of its seat [W/K].
    """

    name: ClassVar[str] = "tool_heating"
    unit: ClassVar[str] = "W/K"
    sizes: ClassVar[tuple[float, float, float]] = (0.8, 2.5, 7.0)

    def draw(self, rng: np.random.Generator) -> None:
        """Choose mass, length and what it loses to the air."""
        self.more["capacity_J_K"] = float(rng.uniform(600.0, 1800.0))
        self.more["length_mm"] = float(rng.uniform(70.0, 140.0))
        self.more["loss_W_K"] = float(rng.uniform(0.3, 1.2))

    def begin(self, spindle: Spindle, drive: Drive) -> None:
        """Take a holder from the magazine, at the air's temperature, when the run begins."""
        self._mounted = drive.family != REST
        self._holder = float(np.interp(drive.time_s[0], drive.grid_s, drive.outside[:, 0]))
        self._end = int(spindle.parts["shaft"][-1])
        self._times, self._values = [float(drive.time_s[0])], [self._holder]

    def heat(self, now: Now, out: Array) -> None:
        """Take heat from the nose."""
        if self._mounted:
            out[self._end] -= self.size * (float(now.temperature[self._end]) - self._holder)

    def advance(self, now: Now, step: float) -> None:
        """Warm the holder, exactly for a nose and air that stay."""
        if not self._mounted:
            return
        air, nose = float(now.look_up()[0]), float(now.temperature[self._end])
        whole = self.size + self.more["loss_W_K"]
        end = (self.size * nose + self.more["loss_W_K"] * air) / whole
        decay = float(np.exp(-step * whole / self.more["capacity_J_K"]))
        self._holder = end + decay * (self._holder - end)
        self._times.append(now.time)
        self._values.append(self._holder)

    def move(self, spindle: Spindle, drive: Drive, temperatures: Array, pose: Array) -> None:
        """Add the holder's growth to the elongation; with no seat there is no holder."""
        if self.size > 0.0:
            warm = np.interp(drive.time_s, self._times, self._values) - self._values[0]
            grown = spindle.p["alpha_steel"] * 1e-3 * self.more["length_mm"] * warm
            pose[:, POSE.index("elongation")] += grown


class EncoderHeat(Hidden):
    """The encoder's electronics at the rear end warm it whenever the control is on."""

    name: ClassVar[str] = "encoder_heat"
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

    name: ClassVar[str] = "pump_pulses"
    unit: ClassVar[str] = "W"
    sizes: ClassVar[tuple[float, float, float]] = (40.0, 80.0, 200.0)
    catalogued: ClassVar[bool] = False
    in_other_words = (("heat_source", ("housing_motor_ym",)), ("heat_source", ("pedestal",)))

    def draw(self, rng: np.random.Generator) -> None:
        """Choose period and share of time."""
        self.more["period_s"] = float(rng.uniform(1500.0, 3600.0))
        self.more["on"] = float(rng.uniform(0.3, 0.5))

    def heat(self, now: Now, out: Array) -> None:
        """Into the motor housing's Y- side and the headstock."""
        if now.time <= 0.0 or (now.time / self.more["period_s"]) % 1.0 > self.more["on"]:
            return
        parts, layout = now.spindle.parts, now.spindle.layout
        rows = (layout.middles("housing") > 0.0) & (layout.middles("housing") < 180.0)
        side = parts["housing"][rows][:, 3 * len(layout.angles) // 4]
        out[side] += 0.5 * self.size / len(side)
        out[parts["pedestal"][0]] += 0.5 * self.size
