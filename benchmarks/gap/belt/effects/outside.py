"""What happens to such machines and what no catalogue holds."""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar

import numpy as np

from benchmarks.gap import enclosed
from benchmarks.gap.belt.machine import Machine
from benchmarks.gap.drive import Array, Drive
from benchmarks.gap.hidden import Hidden, Loosening, X, Y
from benchmarks.gap.march import Now


class DoorOpen(enclosed.DoorOpen):
    """The enclosure's door stands open now and then."""

    drawn: ClassVar[Mapping[str, tuple[float, float]]] = {
        "every_h": (1.3, 2.6),
        "open_h": (0.3, 0.7),
    }


class HydraulicPulses(Hidden):
    """A hydraulic unit behind the column runs in pulses of its own; the size is its watts."""

    unit: ClassVar[str] = "W"
    sizes: ClassVar[tuple[float, float, float]] = (100.0, 300.0, 900.0)
    catalogued: ClassVar[bool] = False
    in_other_words = (("heat_source", ("column",)),)

    drawn: ClassVar[Mapping[str, tuple[float, float]]] = {
        "period_h": (1.0, 2.0),
        "on": (0.3, 0.5),
    }

    def heat(self, now: Now, out: Array) -> None:
        """Warm the column."""
        if now.time > 0.0 and (now.time / 3600.0 / self.more["period_h"]) % 1.0 < self.more["on"]:
            cells = now.machine.parts["column"]
            out[cells] += self.size / len(cells)


class FloodCoolant(Hidden):
    """Cutting coolant runs over flange and nose by a program of its own; the size is W/K."""

    unit: ClassVar[str] = "W/K"
    sizes: ClassVar[tuple[float, float, float]] = (4.0, 12.0, 40.0)
    catalogued: ClassVar[bool] = False

    drawn: ClassVar[Mapping[str, tuple[float, float]]] = {
        "period_h": (1.1, 2.3),
        "colder_K": (1.0, 4.0),
    }

    def begin(self, machine: Machine, drive: Drive) -> None:
        """Find what gets wet."""
        nodes, area = machine.housing.surface("outer", 0.0, machine.drawing.housing[-1].end)
        self._wet, self._share = machine.parts["housing"][nodes], area / area.sum()

    def heat(self, now: Now, out: Array) -> None:
        """Cool the flange."""
        if now.time > 0.0 and (now.time / 3600.0 / self.more["period_h"]) % 1.0 > 0.6:
            cold = now.hall - self.more["colder_K"]
            out[self._wet] += self.size * self._share * (cold - now.temperature[self._wet])


class LooseClamp(Loosening):
    """The headstock's clamp."""

    joint: ClassVar[str] = "clamp"


class SettlingFoundation(Hidden):
    """The machine tilts on its feet by an amount of its own in every run; um after eight hours."""

    unit: ClassVar[str] = "um"
    sizes: ClassVar[tuple[float, float, float]] = (3.0, 9.0, 25.0)
    catalogued: ClassVar[bool] = False

    def draw(self, rng: np.random.Generator) -> None:
        """Keep chance for the runs."""
        self._chance = rng

    def begin(self, machine: Machine, drive: Drive) -> None:
        """Choose this run's direction and pace."""
        self._way = float(self._chance.uniform(-np.pi, np.pi))
        self._pace = float(self._chance.uniform(0.4, 1.6))

    def move(self, machine: Machine, drive: Drive, temperatures: Array, pose: Array) -> None:
        """Move the nose sideways."""
        gone = self.size * self._pace * np.sqrt(drive.time_s / 28800.0)
        pose[:, X] += np.cos(self._way) * gone
        pose[:, Y] += np.sin(self._way) * gone
