"""Effects of the coolant."""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar

import numpy as np

from benchmarks.gap.drive import REST, Array, Drive
from benchmarks.gap.hidden import Hidden, Loosening
from benchmarks.gap.march import Now
from benchmarks.gap.truth.cells import INLET
from benchmarks.gap.truth.spindle import Spindle

JACKETS = ("front", "motor", "rear")


def throttled(left: float) -> dict[str, float]:
    """Return factors on flows and walls' films where a share of the flow is left."""
    flows = {f"flow_{jacket}": left for jacket in JACKETS}
    return flows | {f"wall_{jacket}": left**0.8 for jacket in JACKETS}


class CoolantThermostat(Hidden):
    """A two-point chiller: its tank warms until the upper edge of a dead band, then is cooled.

    The size is half the band [K]. What reaches the jackets swings with the tank; a valve throttles
    the flow while the compressor rests. Where in its cycle a run begins is chance.
    """

    unit: ClassVar[str] = "K"
    sizes: ClassVar[tuple[float, float, float]] = (0.15, 0.4, 1.0)

    drawn: ClassVar[Mapping[str, tuple[float, float]]] = {
        "period_min": (8.0, 35.0),
        "cooling_share": (0.35, 0.65),
    }

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


class CoolantDegradation(Hidden):
    """A filter clogs: flow and wall film fall over the run, by the size after eight hours."""

    unit: ClassVar[str] = "1"
    sizes: ClassVar[tuple[float, float, float]] = (0.1, 0.25, 0.5)

    def scales(self, now: Now) -> dict[str, float]:
        """Return the factors, renewed every five minutes."""
        hours = max(now.time, 0.0) // 300.0 / 12.0
        left = max(1.0 - self.size * hours / 8.0, 0.05)
        return throttled(left)


class CoolantSupplyOffset(Hidden):
    """The pump warms the coolant behind the sensor of its inlet."""

    unit: ClassVar[str] = "K"
    sizes: ClassVar[tuple[float, float, float]] = (0.12, 0.3, 0.7)

    def boundaries(self, now: Now, values: Array) -> None:
        """Raise the inlet."""
        values[INLET] += self.size


class CoolantSplash(Hidden):
    """Cutting coolant wets the headstock and the nose while the brake's cooling is on.

    The size is the conductance of the film of coolant [W/K], which comes a little colder than air.
    """

    unit: ClassVar[str] = "W/K"
    sizes: ClassVar[tuple[float, float, float]] = (10.0, 25.0, 60.0)
    catalogued: ClassVar[bool] = False

    drawn: ClassVar[Mapping[str, tuple[float, float]]] = {
        "period_h": (1.2, 2.2),
        "colder_K": (2.0, 4.0),
    }

    def heat(self, now: Now, out: Array) -> None:
        """Cool the headstock's middle and the nose of the housing."""
        if now.time <= 0.0 or (now.time / 3600.0 / self.more["period_h"]) % 1.0 < 0.6:
            return
        cold = float(now.look()[0]) - self.more["colder_K"]
        parts = now.machine.parts
        cells = parts["pedestal"][:-1]
        out[cells] += 0.8 * self.size / len(cells) * (cold - now.temperature[cells])
        cells = parts["housing"][-1]
        out[cells] += 0.2 * self.size / len(cells) * (cold - now.temperature[cells])


class LooseningBolt(Loosening):
    """The bolt between spindle and headstock."""

    joint: ClassVar[str] = "joint_pedestal"
