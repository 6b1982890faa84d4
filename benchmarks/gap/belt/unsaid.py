"""What this machine has and its owner's page may not say: a mass, a stirred film, a cabinet."""

from __future__ import annotations

from typing import ClassVar

from benchmarks.gap.belt.drive import TOP_FEED
from benchmarks.gap.belt.machine import Machine
from benchmarks.gap.drive import Array, Drive
from benchmarks.gap.enclosed import SteadySource
from benchmarks.gap.hidden import Hidden
from benchmarks.gap.march import Now


class Cabinet(SteadySource):
    """A cabinet on the column warms it, day and night; watts."""

    sizes: ClassVar[tuple[float, float, float]] = (60.0, 150.0, 300.0)
    part: ClassVar[str] = "column"


class StirredNut(Hidden):
    """The moving axis fans its nut; W/K at the highest feed."""

    unit: ClassVar[str] = "W/K"
    sizes: ClassVar[tuple[float, float, float]] = (4.0, 12.0, 30.0)

    def heat(self, now: Now, out: Array) -> None:
        """Let the nut lose more to the air inside."""
        nut, air = (int(now.machine.parts[name][0]) for name in ("z_nut", "air"))
        conductance = self.size * (abs(now.feed) / TOP_FEED) ** 0.7
        lost = conductance * float(now.temperature[nut] - now.temperature[air])
        out[nut] -= lost
        out[air] += lost


class BoltedMass(Hidden):
    """The motor's stator hangs on the headstock and follows it; its heat capacity [J/K]."""

    unit: ClassVar[str] = "J/K"
    sizes: ClassVar[tuple[float, float, float]] = (2e4, 6e4, 1.5e5)
    part: ClassVar[str] = "headstock"
    conductance: ClassVar[float] = 25.0

    def begin(self, machine: Machine, drive: Drive) -> None:
        """Start as warm as the hall was."""
        self._state = float(drive.outside[0, 0]) if drive.time_s[0] < 0.0 else self._state

    def _lost(self, now: Now) -> float:
        return self.conductance * (now.mean(self.part) - self._state)

    def heat(self, now: Now, out: Array) -> None:
        """Take the headstock's heat."""
        cells = now.machine.parts[self.part]
        out[cells] -= self._lost(now) / len(cells)

    def advance(self, now: Now, step: float) -> None:
        """Warm it; the step is short against its time constant."""
        self._state += self._lost(now) * step / self.size
