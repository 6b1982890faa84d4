"""Laws common to all simulators: those fixed by their definition, and those of sensors.

Each simulator has its own laws of films, viscosity, joints and structure, so that they share no
mistakes. What depends on the machine is a number of its row, or a method that its law overrides.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, ClassVar

import numpy as np
import pandas as pd

from benchmarks.gap.drive import REST, Array, Drive, lagged
from benchmarks.gap.hidden import E, Hidden, X, Y
from benchmarks.gap.march import Now

# Sensors.


class SensorLag(Hidden, unit="min", sizes=(2.0, 5.0, 12.0)):
    """One thermometer has bad contact and responds late; the size is the lag [min]."""

    def record(self, number: int, machine: Any, drive: Drive, shown: pd.DataFrame) -> None:
        """Delay the channel."""
        if self.size > 0.0:
            column = f"{self.channel}_degC"
            values = shown[column].to_numpy()
            shown[column] = lagged(drive.time_s, values, 60.0 * self.size)


class SensorOffset(Hidden, unit="K", drawn={"sign": 0.5, "from_run": (1, 4)}):
    """A constant error of one thermometer from one run on; the size is the error [K]."""

    def record(self, number: int, machine: Any, drive: Drive, shown: pd.DataFrame) -> None:
        """Shift the channel."""
        if number >= self.more["from_run"]:
            shown[f"{self.channel}_degC"] += self.more["sign"] * self.size


class SensorDrift(Hidden, unit="K", drawn=SensorOffset.drawn):
    """A reading that drifts away in every run; the size is the error after eight hours [K]."""

    def record(self, number: int, machine: Any, drive: Drive, shown: pd.DataFrame) -> None:
        """Add the drift so far."""
        grown = drive.time_s / (8.0 * 3600.0)
        shown[f"{self.channel}_degC"] += self.more["sign"] * self.size * grown


class FixtureWarming(Hidden, unit="um/K"):
    """The fixture of the radial sensors warms and moves them; the size is um per K."""

    def nose(self, machine: Any, temperatures: Array) -> Array:
        """Return the temperature of the nose next to the fixture [degC], shape (rows,)."""
        return np.asarray(temperatures @ machine.thermometers["front"])

    def move(self, machine: Any, drive: Drive, temperatures: Array, pose: Array) -> None:
        """Shift the radial readings in one direction."""
        share = self.more["of_nose"]
        followed = (1.0 - share) * drive.at() + share * self.nose(machine, temperatures)
        late = lagged(drive.time_s, followed, 3600.0 * self.more["tau_h"])
        shift = self.size * (late - late[0])
        pose[:, X] += np.cos(self.more["direction_rad"]) * shift
        pose[:, Y] += np.sin(self.more["direction_rad"]) * shift


# Bearings.


class FrictionSpeedExponent(Hidden, unit="1", sizes=(0.12, 0.25, 0.45)):
    """Friction heat follows another power of speed; at one speed it is as usual.

    The size is the difference of the exponent from the usual one.
    """

    usual_at_rpm: ClassVar[float]

    def draw(self, rng: np.random.Generator) -> None:
        """Draw whether friction rises more or less steeply."""
        self.more["sign"] = -1.0 if rng.random() < 0.4 else 1.0

    def friction(self, now: Now, viscous: Array, load: Array) -> tuple[Array, Array]:
        """Return both parts, scaled."""
        factor = (now.speed / self.usual_at_rpm) ** (self.more["sign"] * self.size)
        return viscous * factor, load * factor


class BearingRunIn(Hidden, unit="1"):
    """Fresh grease is churned at first: friction x (1 + a exp(-t_running / tau)) in each run.

    The size is the initial excess. The grease flows back between runs.
    """

    def begin(self, machine: Any, drive: Drive) -> None:
        """Reset the running time."""
        self._running = 0.0

    def friction(self, now: Now, viscous: Array, load: Array) -> tuple[Array, Array]:
        """Return both parts, raised."""
        hours = self._running / 3600.0
        factor = 1.0 + self.size * np.exp(-hours / self.more["tau_h"])
        return viscous * factor, load * factor

    def advance(self, now: Now, step: float) -> None:
        """Count the time that the shaft turns."""
        if now.speed > 0.0:
            self._running += step


class ThermalPreload(Hidden, unit="1/K"):
    """The inner ring outgrows the outer, which tightens the bearing, at most eightfold.

    The load grows with a power of what is taken up; the size is the share by which it grows with
    the first kelvin.
    """

    power: ClassVar[float]
    most: ClassVar[float] = 8.0

    def friction(self, now: Now, viscous: Array, load: Array) -> tuple[Array, Array]:
        """Return the load-dependent heat at the preload of now."""
        rings = now.machine.rings
        warmer = np.maximum(rings(now.temperature, "inner") - rings(now.temperature, "outer"), 0.0)
        tight = (1.0 + self.size / self.power * warmer) ** self.power
        return viscous, load * np.minimum(tight, self.most)


class JointResistance(Hidden, unit="1/K", drawn={"sign": 0.6}):
    """The outer rings' seats conduct by how tightly the ring fits: its warming against the housing.

    G = G0 (1 + k (T_ring - T_housing)), or G0 over that where the fit opens, within limits.
    """

    most: ClassVar[float]

    def warmer(self, now: Now) -> dict[str, float]:
        """Return how much warmer the ring of each group of seats is than the housing [K]."""
        raise NotImplementedError

    def scales(self, now: Now) -> dict[str, float]:
        """Return the factors of all seats."""
        found = {}
        for group, warmer in self.warmer(now).items():
            tight = 1.0 + self.size * max(warmer, 0.0)
            factor = tight if self.more["sign"] > 0.0 else 1.0 / tight
            found[group] = float(np.clip(factor, 1.0 / self.most, self.most))
        return found


class CentrifugalShift(Hidden, unit="um"):
    """Balls and rings move the shaft at once by k n^2; the size is the shift at top speed [um]."""

    def move(self, machine: Any, drive: Drive, temperatures: Array, pose: Array) -> None:
        """Shift the nose along the axis."""
        shift = (drive.speed / machine.top_speed) ** 2
        pose[:, E] += self.size * (shift - shift[0])


class BearingStickSlip(Hidden, unit="um"):
    """The floating bearing sticks until shaft and housing have grown apart by the size [um].

    While it sticks, the strained shaft pushes the nose; when it slips, most of the push disappears.
    """

    left: ClassVar[float]
    pushed: ClassVar[float]

    def apart(self, machine: Any, temperatures: Array) -> Array:
        """Return the difference in growth of shaft and housing [um], shape (rows,)."""
        raise NotImplementedError

    def move(self, machine: Any, drive: Drive, temperatures: Array, pose: Array) -> None:
        """Add the push of the strained shaft."""
        apart = self.apart(machine, temperatures)
        seat = float(apart[0])
        for k, now in enumerate(apart.tolist()):
            strain = now - seat
            if abs(strain) > self.size:
                strain *= self.left * self.size / abs(strain)
                seat = now - strain
            pose[k, E] += self.pushed * strain


# Heat.


class Loss(Hidden, unit="W"):
    """Heat that enters the machine in fixed shares, for most where the drive's does."""

    into: ClassVar[float]
    """Share of rotor or pulley [1]."""

    def entry(self, machine: Any) -> Array:
        """Return the share of every unknown, shape (unknowns,)."""
        return np.asarray(machine.drive_entry(self.into))

    def watts(self, now: Now) -> float:
        """Return the heat [W]."""
        raise NotImplementedError

    def begin(self, machine: Any, drive: Drive) -> None:
        """Find where it enters."""
        self._entry = self.entry(machine)

    def heat(self, now: Now, out: Array) -> None:
        """Add it."""
        out += self.watts(now) * self._entry


class MotorIronLoss(Loss):
    """Eddy currents and hysteresis beyond the loss in force; the size is watts at top speed."""

    linear: ClassVar[float]
    """Share in proportion to speed, the rest to its square [1]."""

    def watts(self, now: Now) -> float:
        """Return the loss at this speed."""
        n = now.speed / now.machine.top_speed
        return self.size * (self.linear * n + (1.0 - self.linear) * n**2)


class CopperLoss(Loss):
    """I^2 R (1 + 0.0039 dT), current in proportion to torque; the size is watts at one torque."""

    at_Nm: ClassVar[float]  # noqa: N815
    part: ClassVar[str]

    def watts(self, now: Now) -> float:
        """Return the loss at this torque."""
        warm = 1.0 + 0.0039 * (now.mean(self.part) - 20.0)
        return self.size * (now.torque / self.at_Nm) ** 2 * warm


class Windage(Loss):
    """Air friction, k n^3; the size is watts at top speed."""

    def watts(self, now: Now) -> float:
        """Return the loss at this speed."""
        return float(self.size * (now.speed / now.machine.top_speed) ** 3)


class CuttingHeat(Loss, unit="1"):
    """A share of the cutting power goes into tool and nose; the size is that share."""

    def watts(self, now: Now) -> float:
        """Return the share of torque times speed."""
        return float(self.size * now.torque * now.speed * np.pi / 30.0)


class PartSource(Hidden, unit="W", catalogued=False):
    """A heat source in a part, or in some of its cells, that is on from the start of a run."""

    part: ClassVar[str]
    cells: ClassVar[Sequence[int | None]] = (None,)
    """Of its cells, as of `slice`."""

    def watts(self, now: Now) -> float:
        """Return the power during the run [W]."""
        return self.size

    def heat(self, now: Now, out: Array) -> None:
        """Warm the part."""
        cells = now.machine.parts[self.part][slice(*self.cells)]
        out[cells] += (self.watts(now) if now.time > 0.0 else 0.0) / len(cells)


class ToolHeating(Hidden, unit="W/K", sizes=(0.8, 2.5, 7.0)):
    """A holder from the magazine takes heat from the nose, and grows.

    The size is the conductance of its seat [W/K].
    """

    def seat(self, machine: Any) -> tuple[Any, Array]:
        """Return the unknowns of the nose at the seat, and the share of each."""
        raise NotImplementedError

    def begin(self, machine: Any, drive: Drive) -> None:
        """Mount a holder at air temperature when the run begins."""
        self._mounted = drive.family != REST
        self._nose, self._share = self.seat(machine)
        self._holder = float(np.interp(drive.time_s[0], drive.grid_s, drive.outside[:, 0]))
        self._times, self._values = [float(drive.time_s[0])], [self._holder]

    def _warm(self, now: Now) -> float:
        return float(now.temperature[self._nose] @ self._share)

    def heat(self, now: Now, out: Array) -> None:
        """Take heat from the nose."""
        if self._mounted:
            out[self._nose] -= self.size * (self._warm(now) - self._holder) * self._share

    def advance(self, now: Now, step: float) -> None:
        """Warm the holder, exactly for constant temperatures of nose and air."""
        if not self._mounted:
            return
        whole, air = self.size + self.more["loss_W_K"], float(now.look()[0])
        end = (self.size * self._warm(now) + self.more["loss_W_K"] * air) / whole
        decay = float(np.exp(-step * whole / self.more["capacity_J_K"]))
        self._holder = end + decay * (self._holder - end)
        self._times.append(now.time)
        self._values.append(self._holder)

    def move(self, machine: Any, drive: Drive, temperatures: Array, pose: Array) -> None:
        """Add the holder's growth; without a conductance there is no holder."""
        if self.size > 0.0:
            warm = np.interp(drive.time_s, self._times, self._values) - self._values[0]
            pose[:, E] += machine.p["alpha_steel"] * 1e-3 * self.more["length_mm"] * warm


# Surfaces, joints and structure.


class ForcedConvection(Hidden, unit="1"):
    """The turning spindle stirs the air: h = h0 (1 + c (n / top speed)^0.7)."""

    reach: ClassVar[Mapping[str, float]]
    """How much of the wind reaches each group of surfaces [1]."""

    def scales(self, now: Now) -> dict[str, float]:
        """Return the factors at this speed."""
        wind = self.size * (now.speed / now.machine.top_speed) ** 0.7
        return {group: 1.0 + reach * wind for group, reach in self.reach.items()}


class SurfaceExchange(Hidden):
    """Heat exchange of surfaces beyond their constant films, by area and temperatures."""

    def begin(self, machine: Any, drive: Drive) -> None:
        """Collect the machine's surfaces."""
        self._cells, self._areas = machine.faces

    def flux(self, own: Array, around: Array | float) -> Array:
        """Return the heat into surfaces [W/m2] from their and the air's temperatures [degC]."""
        raise NotImplementedError

    def heat(self, now: Now, out: Array) -> None:
        """Add what the surfaces gain from what is around them."""
        around = now.machine.around(now)
        gained = self._areas * self.flux(now.temperature[self._cells], around)
        np.add.at(out, self._cells, gained)
        now.machine.take_from_air(gained, out)


class Loosening(
    Hidden, unit="1", sizes=(0.3, 0.6, 0.9), catalogued=False, drawn={"at_h": (1.5, 3.5)}
):
    """A joint suddenly loosens in every run; the size is the share of its conductance lost."""

    joint: ClassVar[str]

    def scales(self, now: Now) -> dict[str, float]:
        """Return the joint's factor."""
        loose = now.time > 3600.0 * self.more["at_h"]
        return {self.joint: 1.0 - self.size} if loose else {}


class SlowStructure(Hidden, unit="um/K", sizes=(4.0, 9.0, 20.0)):
    """The bed follows its surroundings over many hours and carries the work away; um per K."""

    forward: ClassVar[float] = 0.0
    """How much the direction leans towards the axis [1]."""

    def draw(self, rng: np.random.Generator) -> None:
        """Choose time constant and direction."""
        self.more["tau_h"] = float(rng.uniform(3.0, 10.0))
        direction = rng.normal(size=3)
        direction[2] += self.forward * np.sign(direction[2])
        direction /= np.linalg.norm(direction)
        for name, value in zip("xyz", direction.tolist(), strict=True):
            self.more[f"along_{name}"] = value

    def follows(self, machine: Any, drive: Drive, temperatures: Array) -> Array:
        """Return what the bed follows, from its start [K], shape (rows,)."""
        return drive.at() - drive.at()[0]

    def move(self, machine: Any, drive: Drive, temperatures: Array, pose: Array) -> None:
        """Shift the nose without tilting it."""
        followed = self.follows(machine, drive, temperatures)
        late = lagged(drive.time_s, followed, 3600.0 * self.more["tau_h"])
        for axis, name in ((X, "x"), (Y, "y"), (E, "z")):
            pose[:, axis] += self.size * self.more[f"along_{name}"] * late
