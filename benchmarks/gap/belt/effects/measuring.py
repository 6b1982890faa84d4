"""Effects on what the thermometers show."""

from __future__ import annotations

from typing import ClassVar

import numpy as np
import pandas as pd

from benchmarks.gap.belt.drive import Drive
from benchmarks.gap.belt.machine import Machine
from benchmarks.gap.enclosed import Hidden
from benchmarks.gap.truth.effects.base import lagged

THERMOMETERS = (
    "front",
    "front_below",
    "rear",
    "headstock",
    "column_top",
    "column",
    "nut",
    "inside",
)
QUICK = ("front", "front_below", "rear", "nut", "inside")


class SensorLag(Hidden):
    """One thermometer has bad contact and answers late; the size is minutes."""

    name: ClassVar[str] = "sensor_lag"
    unit: ClassVar[str] = "min"
    sizes: ClassVar[tuple[float, float, float]] = (2.0, 5.0, 12.0)
    channels: ClassVar[tuple[str, ...]] = QUICK

    def record(self, number: int, machine: Machine, drive: Drive, shown: pd.DataFrame) -> None:
        """Delay the channel."""
        if self.size > 0.0:
            column = f"{self.channel}_degC"
            values = shown[column].to_numpy()
            shown[column] = lagged(drive.time_s, values, 60.0 * self.size)


class _Wrong(Hidden):
    """One thermometer reads wrong, up or down."""

    channels: ClassVar[tuple[str, ...]] = THERMOMETERS

    def draw(self, rng: np.random.Generator) -> None:
        """Choose sign and first run."""
        self.more["sign"] = 1.0 if rng.random() < 0.5 else -1.0
        self.more["from_run"] = float(rng.integers(1, 4))


class SensorOffset(_Wrong):
    """It reads wrong by a constant from one run on; the size is K."""

    name: ClassVar[str] = "sensor_offset"
    unit: ClassVar[str] = "K"
    sizes: ClassVar[tuple[float, float, float]] = (0.3, 0.8, 2.5)

    def record(self, number: int, machine: Machine, drive: Drive, shown: pd.DataFrame) -> None:
        """Shift the channel."""
        if number >= self.more["from_run"]:
            shown[f"{self.channel}_degC"] += self.more["sign"] * self.size


class SensorDrift(_Wrong):
    """It wanders away in every run; the size is K after eight hours."""

    name: ClassVar[str] = "sensor_drift"
    unit: ClassVar[str] = "K"
    sizes: ClassVar[tuple[float, float, float]] = (0.3, 0.9, 2.4)

    def record(self, number: int, machine: Machine, drive: Drive, shown: pd.DataFrame) -> None:
        """Add what has grown so far."""
        grown = drive.time_s / (8.0 * 3600.0)
        shown[f"{self.channel}_degC"] += self.more["sign"] * self.size * grown
