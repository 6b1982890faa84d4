"""Laws of the jig borer's effects, beside those common to all simulators."""

from __future__ import annotations

from typing import Any

import numpy as np

from benchmarks.gap import laws
from benchmarks.gap.drive import REST, Array, Drive, lagged
from benchmarks.gap.hidden import Hidden, X, Y
from benchmarks.gap.march import Now
from benchmarks.gap.truth.cells import AIR, HALL, INLET
from benchmarks.gap.truth.laws import viscous_torque, vogel_factor, watts
from benchmarks.gap.truth.spindle import POSE, Spindle

YAW, PITCH = (POSE.index(name) for name in ("yaw", "pitch"))
JACKETS = ("front", "motor", "rear")

# Bearings.


class ViscosityTemperature(Hidden, unit="1/K"):
    """The oil thins by Vogel's equation; the film sits between ring and balls."""

    def friction(self, now: Now, viscous: Array, load: Array) -> tuple[Array, Array]:
        """Return the heat at the viscosity that the film has."""
        spindle, t = now.machine, now.temperature
        film = 0.7 * spindle.rings(t, "inner") + 0.3 * spindle.rings(t, "balls")
        nu = spindle.p["viscosity"] * vogel_factor(film - 25.0, self.size)
        if self.size == 0.0:
            return viscous, load
        return watts(now.speed, viscous_torque(spindle.f0, nu, now.speed)), load


class UnevenBearingHeating(Hidden, unit="1"):
    """More heat on one side of the outer rings: that share of the bearings' heat changes sides."""

    def begin(self, spindle: Spindle, drive: Drive) -> None:
        """Compute where the heat moves to."""
        angles = spindle.layout.angles
        around = np.cos(angles - self.more["direction_rad"]) / len(angles)
        self._around = self.size * around

    def heat(self, now: Now, out: Array) -> None:
        """Move heat from one side to the other."""
        total = np.sum(now.machine.friction(now.speed), axis=0)
        out[now.machine.parts["outer"]] += total[:, None] * self._around


class JointResistance(laws.JointResistance):
    """Rear and front seats in their sections of the housing."""

    def warmer(self, now: Now) -> dict[str, float]:
        """Return rings against the housing around them [K]."""
        outer = now.machine.rings(now.temperature, "outer")
        parts, rows = now.machine.parts, now.machine.layout.middles("housing")
        housing = now.temperature[parts["housing"]].mean(axis=1)
        return {
            "joint_outer_rear": float(outer[:2].mean() - housing[rows < 0.0].mean()),
            "joint_outer_front": float(outer[2:].mean() - housing[rows > 180.0].mean()),
        }


# Coolant.


def throttled(left: float) -> dict[str, float]:
    """Return factors on flows and walls' films where a share of the flow is left."""
    flows = {f"flow_{jacket}": left for jacket in JACKETS}
    return flows | {f"wall_{jacket}": left**0.8 for jacket in JACKETS}


class CoolantThermostat(Hidden, unit="K"):
    """A two-point chiller: its tank warms until the upper edge of a dead band, then is cooled.

    The size is half the band [K]. What reaches the jackets swings with the tank; a valve throttles
    the flow while the compressor rests. Where in its cycle a run begins is chance.
    """

    def draw(self, rng: np.random.Generator) -> None:
        """Choose the period and how long the compressor runs in it; keep chance for the runs."""
        super().draw(rng)
        self._chance = rng

    def begin(self, spindle: Spindle, drive: Drive) -> None:
        """Start anywhere in the band; before the run it is taken to hold its mean."""
        self._resting = drive.family == REST
        place = 0.0 if self._resting else float(self._chance.uniform(-1.0, 1.0))
        self._tank = place * self.size
        self._cooling = self._resting or bool(self._chance.random() < 0.5)

    def scales(self, now: Now) -> dict[str, float]:
        """Return the flow's factor; the wall film falls with flow^0.8."""
        if self._cooling:
            return {}
        # A chiller with a wide band rests for long, and its valve closes further meanwhile.
        left = 1.0 - 0.5 * min(self.size, 1.0)
        return throttled(left)

    def boundaries(self, now: Now, values: Array) -> None:
        """The tank's temperature reaches the jackets."""
        values[INLET] += self._tank

    def advance(self, now: Now, step: float) -> None:
        """Warm or cool the tank and switch at the edges."""
        if self._resting:
            return
        share = self.more["cooling_share"]
        time_s = 60.0 * self.more["period_min"] * (share if self._cooling else 1.0 - share)
        self._tank += (-1.0 if self._cooling else 1.0) * 2.0 * self.size / time_s * step
        if self._tank >= self.size:
            self._cooling = True
        elif self._tank <= -self.size:
            self._cooling = False


class CoolantDegradation(Hidden, unit="1"):
    """A filter clogs: flow and wall film fall over the run, by the size after eight hours."""

    def scales(self, now: Now) -> dict[str, float]:
        """Return the factors, renewed every five minutes."""
        hours = max(now.time, 0.0) // 300.0 / 12.0
        left = max(1.0 - self.size * hours / 8.0, 0.05)
        return throttled(left)


class CoolantSupplyOffset(Hidden, unit="K"):
    """The pump warms the coolant behind the sensor of its inlet."""

    def boundaries(self, now: Now, values: Array) -> None:
        """Raise the inlet."""
        values[INLET] += self.size


class CoolantSplash(Hidden, unit="W/K", catalogued=False):
    """Cutting coolant wets the headstock and the nose while the brake's cooling is on.

    The size is the conductance of the film of coolant [W/K], which comes a little colder than air.
    """

    def heat(self, now: Now, out: Array) -> None:
        """Cool the headstock's middle and the nose of the housing."""
        if now.time <= 0.0 or (now.time / 3600.0 / self.more["period_h"]) % 1.0 < 0.6:
            return
        cold = float(now.look()[0]) - self.more["colder_K"]
        parts = now.machine.parts
        for cells, share in ((parts["pedestal"][:-1], 0.8), (parts["housing"][-1], 0.2)):
            out[cells] += share * self.size / len(cells) * (cold - now.temperature[cells])


# Motor, turning parts and cutting.


class Windage(laws.Windage):
    """Most of it in the motor's gap, some at the nose."""

    def entry(self, spindle: Spindle) -> Array:
        """Return the share of every cell."""
        entry = 0.85 * spindle.drive_entry(0.5)
        entry[spindle.parts["shaft"]] += 0.15 * spindle.layout.share("shaft", 200.0, 400.0)
        return entry


class CuttingHeat(laws.CuttingHeat):
    """Most of it into the bar, a third into the nose."""

    def entry(self, spindle: Spindle) -> Array:
        """Return the share of every cell."""
        entry, bar = np.zeros(len(spindle.capacity)), spindle.parts["bar"]
        entry[bar] = 0.65 / len(bar)
        entry[spindle.parts["shaft"]] += 0.35 * spindle.layout.share("shaft", 340.0, 400.0)
        return entry


class ToolHeating(laws.ToolHeating):
    """It sits on the shaft's last cell."""

    def seat(self, spindle: Spindle) -> tuple[Any, Array]:
        """Return that cell."""
        return spindle.parts["shaft"][-1:], np.ones(1)


class EncoderHeat(laws.Loss, catalogued=False):
    """The encoder's electronics at the rear end warm it whenever the control is on."""

    def entry(self, spindle: Spindle) -> Array:
        """It sits at the last cells of housing and shaft."""
        entry, sides = np.zeros(len(spindle.capacity)), spindle.parts["housing"][0]
        entry[sides] = 0.7 / len(sides)
        entry[spindle.parts["shaft"][0]] = 0.3
        return entry

    def watts(self, now: Now) -> float:
        """Switched on half an hour into the run."""
        return self.size if now.time > 1800.0 else 0.0


class PumpPulses(Hidden, unit="W", catalogued=False):
    """A hydraulic pump at the headstock runs in pulses of its own, and warms it."""

    def heat(self, now: Now, out: Array) -> None:
        """Into the motor housing's Y- side and the headstock."""
        if now.time <= 0.0 or (now.time / self.more["period_s"]) % 1.0 > self.more["on"]:
            return
        parts, layout = now.machine.parts, now.machine.layout
        rows = (layout.middles("housing") > 0.0) & (layout.middles("housing") < 180.0)
        side = parts["housing"][rows][:, 3 * len(layout.angles) // 4]
        out[side] += 0.5 * self.size / len(side)
        out[parts["pedestal"][0]] += 0.5 * self.size


# Structure.


class ColumnBending(Hidden, unit="urad/K"):
    """The column's skin follows structure minus air late, and bends it; urad per K."""

    def move(self, spindle: Spindle, drive: Drive, temperatures: Array, pose: Array) -> None:
        """Tilt the nose and carry it along."""
        structure = 0.5 * (
            temperatures[:, spindle.parts["pedestal"]].mean(axis=1)
            + temperatures[:, spindle.parts["column"]].mean(axis=1)
        )
        late = lagged(drive.time_s, structure - drive.at(1), 3600.0 * self.more["tau_h"])
        tilt = self.size * (late - late[0])
        arm = self.more["lever_mm"] * 1e-3
        for shift, angle, around in ((X, YAW, np.cos), (Y, PITCH, np.sin)):
            share = around(self.more["direction_rad"])
            pose[:, angle] += share * tilt
            pose[:, shift] += share * arm * tilt


class SlowStructure(laws.SlowStructure):
    """It follows hall and base."""

    def follows(self, spindle: Spindle, drive: Drive, temperatures: Array) -> Array:
        """Return half of both."""
        base = temperatures[:, spindle.parts["pedestal"]].mean(axis=1)
        return np.asarray(0.5 * (drive.at(1) - drive.at(1)[0]) + 0.5 * (base - base[0]))


class BearingStickSlip(laws.BearingStickSlip):
    """The rear bearing floats."""

    def apart(self, spindle: Spindle, temperatures: Array) -> Array:
        """Return how far shaft and housing have grown apart [um]."""
        rise = temperatures - temperatures[0]
        layout, parts = spindle.layout, spindle.parts
        steel = spindle.p["alpha_steel"] * 1e-3
        span = 375.0
        shaft = rise[:, parts["shaft"]] @ layout.share("shaft", -75.0, 300.0)
        housing = rise[:, parts["housing"]].mean(axis=2) @ layout.share("housing", -75.0, 300.0)
        return np.asarray(steel * span * (shaft - housing))


class FixtureWarming(laws.FixtureWarming):
    """The fixture stands around the housing's end."""

    def nose(self, spindle: Spindle, temperatures: Array) -> Array:
        """Return the temperature of the housing's end [degC]."""
        return np.asarray(temperatures[:, spindle.parts["housing"][-1]].mean(axis=1))


# Outer surfaces.


class NaturalConvection(laws.SurfaceExchange, unit="W/(m2 K^1.25)"):
    """Buoyancy: h = c |dT|^(1/4) on top of the constant film."""

    def flux(self, own: Array, around: Array | float) -> Array:
        """Return the heat into surfaces [W/m2]."""
        difference = around - own
        return np.asarray(self.size * np.abs(difference) ** 0.25 * difference)


class Radiation(laws.SurfaceExchange, unit="1"):
    """Grey surfaces in a hall whose walls have the air's temperature."""

    def begin(self, spindle: Spindle, drive: Drive) -> None:
        """Take as much of the surfaces as is black."""
        super().begin(spindle, drive)
        self._areas = self.size * self._areas

    def flux(self, own: Array, around: Array | float) -> Array:
        """Return the heat into black surfaces [W/m2]."""
        return np.asarray(5.670374e-8 * ((around + 273.15) ** 4 - (own + 273.15) ** 4))


class SunPatch(Hidden, unit="W", catalogued=False):
    """The sun shines on the X+ side of headstock and column for some hours of the day."""

    def heat(self, now: Now, out: Array) -> None:
        """Warm housing (the X+ half), headstock and column."""
        place = (now.time / 3600.0 - self.more["from_h"]) / self.more["hours"]
        if not 0.0 < place < 1.0:
            return
        power = self.size * float(np.sin(np.pi * place))
        parts, layout = now.machine.parts, now.machine.layout
        front = layout.middles("housing") > 180.0
        facing = np.maximum(np.cos(layout.angles), 0.0)
        housing = parts["housing"][front]
        out[housing] += 0.35 * power * facing / facing.sum() / len(housing)
        for name, share in (("pedestal", 0.35), ("column", 0.3)):
            out[parts[name]] += share * power / len(parts[name])


class DoorDraft(Hidden, unit="K", catalogued=False):
    """The hall's door opens: air some K colder at the column's foot, which T5 hardly sees."""

    def boundaries(self, now: Now, values: Array) -> None:
        """Cool the air at column and bed, and a little at the spindle."""
        hour = now.time / 3600.0
        if now.time > 0.0 and (hour + 0.7) % self.more["every_h"] < self.more["open_h"]:
            values[HALL] -= self.size
            values[AIR] -= 0.3 * self.size
