"""Effects of motor, air, structure and thermometers."""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar

import numpy as np

from benchmarks.gap import enclosed
from benchmarks.gap.belt.effects import measuring
from benchmarks.gap.belt.effects.structure import FixtureWarming, SlowStructure
from benchmarks.gap.drive import Array, Drive, lagged
from benchmarks.gap.hidden import Hidden, Loosening, X
from benchmarks.gap.lathe.machine import TOP_SPEED, Lathe
from benchmarks.gap.march import Now

__all__ = ["FixtureWarming", "SlowStructure"]


class MotorIronLoss(Hidden):
    """The spindle motor loses more with speed and its square; watts at 4,000 r/min."""

    unit: ClassVar[str] = "W"
    sizes: ClassVar[tuple[float, float, float]] = (60.0, 200.0, 600.0)

    def heat(self, now: Now, out: Array) -> None:
        """Add a fifth in proportion to speed, the rest to its square."""
        n = now.speed / TOP_SPEED
        out[now.machine.parts["spindle_motor"]] += self.size * (0.2 * n + 0.8 * n**2)


class ForcedConvection(Hidden):
    """The turning chuck stirs the air inside, where all films grow: h0 (1 + c (n/4,000)^0.7)."""

    unit: ClassVar[str] = "1"
    sizes: ClassVar[tuple[float, float, float]] = (0.5, 1.5, 4.0)
    in_other_words = (("conductance_with_motion", ("*", "inside", "speed")),)

    def scales(self, now: Now) -> dict[str, float]:
        """Return the factor at this speed."""
        return {"film_inside": 1.0 + self.size * (now.speed / TOP_SPEED) ** 0.7}


class _Surface(enclosed.SurfaceExchange, named=False):
    """Exchange of surfaces in the hall beyond the constant film."""

    def begin(self, machine: Lathe, drive: Drive) -> None:
        """Collect the areas."""
        parts = {n: one for n, one in machine.drawing.parts.items() if one.air == "hall"}
        self._cells = np.concatenate([machine.parts[name] for name in parts])
        self._areas = np.concatenate(
            [
                np.full(len(machine.parts[n]), one.surface / len(machine.parts[n]))
                for n, one in parts.items()
            ]
        )

    def heat(self, now: Now, out: Array) -> None:
        """Add what the surfaces gain."""
        out[self._cells] += self._areas * self.flux(now.temperature[self._cells], now.hall)


class NaturalConvection(enclosed.NaturalConvection, _Surface):
    """Buoyancy on surfaces in the hall."""


class Radiation(enclosed.Radiation, _Surface):
    """Surfaces in the hall are grey."""


class ColumnBending(Hidden):
    """The bed warps late with its warmth above the hall, which tilts the headstock; urad per K."""

    unit: ClassVar[str] = "urad/K"
    sizes: ClassVar[tuple[float, float, float]] = (5.0, 15.0, 35.0)

    def draw(self, rng: np.random.Generator) -> None:
        """Choose time constant and lever; the bed warps one way or the other."""
        self.more["tau_h"] = float(rng.uniform(0.6, 3.0))
        self.more["lever_mm"] = float(rng.uniform(300.0, 700.0))
        self.more["sign"] = 1.0 if rng.random() < 0.5 else -1.0

    def move(self, machine: Lathe, drive: Drive, temperatures: Array, pose: Array) -> None:
        """Carry the spindle along."""
        bed = temperatures[:, machine.parts["bed"]].mean(axis=1)
        late = lagged(drive.time_s, bed - drive.at(), 3600.0 * self.more["tau_h"])
        tilt = self.more["sign"] * self.size * (late - late[0])
        pose[:, X] += tilt * self.more["lever_mm"] * 1e-3


THERMOMETERS = (
    *("front", "rear", "bed_left", "bed_right", "slide", "z_nut", "z_motor", "x_nut", "x_motor"),
    *("motor", "inside"),
)


class SensorLag(measuring.SensorLag):
    """One thermometer answers late."""

    channels: ClassVar[tuple[str, ...]] = ("front", "rear", "z_nut", "x_nut", "z_motor", "inside")


class SensorOffset(measuring.SensorOffset):
    """One thermometer reads wrong by a constant."""

    channels: ClassVar[tuple[str, ...]] = THERMOMETERS


class SensorDrift(measuring.SensorDrift):
    """One thermometer wanders away."""

    channels: ClassVar[tuple[str, ...]] = THERMOMETERS


class DoorOpen(enclosed.DoorOpen):
    """The door of the working space stands open now and then."""

    drawn: ClassVar[Mapping[str, tuple[float, float]]] = {
        "every_h": (1.2, 2.4),
        "open_h": (0.3, 0.7),
    }


class ChipHeap(Hidden):
    """Hot chips pile up on the bed and are carried off, by a program of its own; watts."""

    unit: ClassVar[str] = "W"
    sizes: ClassVar[tuple[float, float, float]] = (100.0, 300.0, 900.0)
    catalogued: ClassVar[bool] = False
    in_other_words = (("heat_source", ("bed_left",)), ("heat_source", ("bed_middle",)))

    drawn: ClassVar[Mapping[str, tuple[float, float]]] = {"period_h": (0.8, 1.8)}

    def heat(self, now: Now, out: Array) -> None:
        """Warm the bed under the chuck, more and more until they are carried off."""
        if now.time > 0.0:
            cells = now.machine.parts["bed"][6:12]
            heap = (now.time / 3600.0 / self.more["period_h"]) % 1.0
            out[cells] += 2.0 * self.size * heap / len(cells)


class LooseGib(Loosening):
    """The carriage's gib."""

    sizes: ClassVar[tuple[float, float, float]] = (0.4, 0.7, 0.95)
    joint: ClassVar[str] = "z_guide"
