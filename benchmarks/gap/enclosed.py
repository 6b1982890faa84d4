"""Laws common to the belt-driven spindle and the lathe, which both have an enclosure."""

from __future__ import annotations

from typing import Any, ClassVar

import numpy as np

from benchmarks.gap import laws
from benchmarks.gap.belt.drive import TOP_FEED
from benchmarks.gap.drive import Array, Drive
from benchmarks.gap.hidden import Hidden
from benchmarks.gap.march import Now


class NaturalConvection(laws.SurfaceExchange, unit="W/(m2 K^1.33)", sizes=(0.8, 2.0, 4.0)):
    """Buoyancy: h = c |dT|^(1/3), as on large surfaces."""

    def flux(self, own: Array, around: Array | float) -> Array:
        """Return the heat into surfaces [W/m2]."""
        return np.asarray(self.size * np.cbrt(np.abs(around - own)) * (around - own))


class Radiation(laws.SurfaceExchange, unit="1", sizes=(0.25, 0.5, 0.85)):
    """Grey surfaces; walls have the temperature of the air in front of them."""

    def flux(self, own: Array, around: Array | float) -> Array:
        """Return the heat into surfaces [W/m2]."""
        beyond = (around + 273.15) ** 4 - (own + 273.15) ** 4
        return np.asarray(self.size * 5.670374e-8 * beyond)


class DoorOpen(Hidden, unit="W/K", sizes=(40.0, 120.0, 400.0), catalogued=False):
    """The door is periodically open for a while and exchanges the air inside.

    The size is the exchange with the hall while it is open [W/K].
    """

    def heat(self, now: Now, out: Array) -> None:
        """Let hall air in."""
        open_now = (now.time / 3600.0 + 0.5) % self.more["every_h"] < self.more["open_h"]
        if now.time > 0.0 and open_now:
            air = int(now.machine.parts["air"][0])
            out[air] += self.size * (now.hall - float(now.temperature[air]))


# What an owner's file may not say.


class StirredNut(Hidden, unit="W/K", sizes=(4.0, 12.0, 30.0)):
    """The moving axis fans its nut; W/K at the highest feed."""

    def heat(self, now: Now, out: Array) -> None:
        """Let the nut lose more to the air inside."""
        nut, air = (int(now.machine.parts[name][0]) for name in ("z_nut", "air"))
        conductance = self.size * (abs(now.feed) / TOP_FEED) ** 0.7
        lost = conductance * float(now.temperature[nut] - now.temperature[air])
        out[nut] -= lost
        out[air] += lost


class BoltedMass(Hidden, unit="J/K", sizes=(2e4, 6e4, 1.5e5)):
    """A mass hangs on a part and follows it; the size is its heat capacity [J/K]."""

    part: ClassVar[str]
    conductance: ClassVar[float]

    def begin(self, machine: Any, drive: Drive) -> None:
        """Start as warm as the hall was."""
        self._state = float(drive.outside[0, 0]) if drive.time_s[0] < 0.0 else self._state

    def _lost(self, now: Now) -> float:
        return self.conductance * (now.mean(self.part) - self._state)

    def heat(self, now: Now, out: Array) -> None:
        """Take the part's heat."""
        cells = now.machine.parts[self.part]
        out[cells] -= self._lost(now) / len(cells)

    def advance(self, now: Now, step: float) -> None:
        """Warm it; the step is short against its time constant."""
        self._state += self._lost(now) * step / self.size
