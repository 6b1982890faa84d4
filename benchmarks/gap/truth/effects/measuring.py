"""Effects on what the sensors show."""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar

import numpy as np

from benchmarks.gap import hidden
from benchmarks.gap.drive import Array
from benchmarks.gap.truth.spindle import Spindle

THERMOMETERS = ("T1", "T2", "T3", "T4", "T6", "T7", "T8", "T10", "T11")
QUICK = ("T1", "T3", "T4", "T6", "T7", "T8", "T11")


class FixtureWarming(hidden.FixtureWarming):
    """The fixture stands around the housing's end."""

    sizes: ClassVar[tuple[float, float, float]] = (1.2, 2.5, 5.0)
    drawn: ClassVar[Mapping[str, tuple[float, float]]] = {
        "tau_h": (0.3, 1.0),
        "of_nose": (0.15, 0.3),
        "direction_rad": (0.0, 2.0 * np.pi),
    }

    def nose(self, machine: Spindle, temperatures: Array) -> Array:
        """Return the temperature of the housing's end [degC]."""
        return np.asarray(temperatures[:, machine.parts["housing"][-1]].mean(axis=1))


class SensorLag(hidden.SensorLag):
    """One of the thermometers on quick parts answers late."""

    channels: ClassVar[tuple[str, ...]] = QUICK


class SensorOffset(hidden.SensorOffset):
    """One thermometer reads wrong by a constant from one run on."""

    sizes: ClassVar[tuple[float, float, float]] = (0.25, 0.6, 2.0)
    channels: ClassVar[tuple[str, ...]] = THERMOMETERS


class SensorDrift(hidden.SensorDrift):
    """One thermometer wanders away in every run."""

    sizes: ClassVar[tuple[float, float, float]] = (0.3, 0.8, 1.8)
    channels: ClassVar[tuple[str, ...]] = THERMOMETERS

    def draw(self, rng: np.random.Generator) -> None:
        """Choose the sign; there is no first run."""
        super().draw(rng)
        del self.more["from_run"]
