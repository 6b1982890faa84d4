"""Effects on what the sensors show."""

from __future__ import annotations

from typing import ClassVar

import numpy as np
import pandas as pd

from benchmarks.gap.truth.drive import Drive
from benchmarks.gap.truth.effects.base import Array, Hidden, lagged
from benchmarks.gap.truth.spindle import POSE, Spindle

THERMOMETERS = ("T1", "T2", "T3", "T4", "T6", "T7", "T8", "T10", "T11")
QUICK = ("T1", "T3", "T4", "T6", "T7", "T8", "T11")


class FixtureWarming(Hidden):
    """The sensors' own fixture warms and takes the radial sensors along; um per K."""

    name: ClassVar[str] = "fixture_warming"
    unit: ClassVar[str] = "um/K"
    sizes: ClassVar[tuple[float, float, float]] = (1.2, 2.5, 5.0)

    def draw(self, rng: np.random.Generator) -> None:
        """Choose time constant, share of the nose's heat, and direction."""
        self.more["tau_h"] = float(rng.uniform(0.3, 1.0))
        self.more["of_nose"] = float(rng.uniform(0.15, 0.3))
        self.more["direction_rad"] = float(rng.uniform(0.0, 2.0 * np.pi))

    def move(self, spindle: Spindle, drive: Drive, temperatures: Array, pose: Array) -> None:
        """Shift all radial readings alike."""
        nose = temperatures[:, spindle.parts["housing"][-1]].mean(axis=1)
        share = self.more["of_nose"]
        late = lagged(
            drive.time_s, (1.0 - share) * drive.at(0) + share * nose, 3600.0 * self.more["tau_h"]
        )
        shift = self.size * (late - late[0])
        pose[:, POSE.index("x")] += np.cos(self.more["direction_rad"]) * shift
        pose[:, POSE.index("y")] += np.sin(self.more["direction_rad"]) * shift


class SensorLag(Hidden):
    """One thermometer has bad contact and answers late; the size is minutes."""

    name: ClassVar[str] = "sensor_lag"
    unit: ClassVar[str] = "min"
    sizes: ClassVar[tuple[float, float, float]] = (2.0, 5.0, 12.0)
    channels: ClassVar[tuple[str, ...]] = QUICK

    def record(self, number: int, drive: Drive, shown: pd.DataFrame) -> None:
        """Delay the channel."""
        if self.size > 0.0:
            column = f"{self.channel}_degC"
            values = shown[column].to_numpy()
            shown[column] = lagged(drive.time_s, values, 60.0 * self.size)


class SensorOffset(Hidden):
    """One thermometer reads wrong by a constant from one run on; the size is K."""

    name: ClassVar[str] = "sensor_offset"
    unit: ClassVar[str] = "K"
    sizes: ClassVar[tuple[float, float, float]] = (0.25, 0.6, 2.0)
    channels: ClassVar[tuple[str, ...]] = THERMOMETERS

    def draw(self, rng: np.random.Generator) -> None:
        """Choose sign and first run."""
        self.more["sign"] = 1.0 if rng.random() < 0.5 else -1.0
        self.more["from_run"] = float(rng.integers(1, 4))

    def record(self, number: int, drive: Drive, shown: pd.DataFrame) -> None:
        """Shift the channel."""
        if number >= self.more["from_run"]:
            shown[f"{self.channel}_degC"] += self.more["sign"] * self.size


class SensorDrift(Hidden):
    """One thermometer wanders away in every run; the size is K after eight hours."""

    name: ClassVar[str] = "sensor_drift"
    unit: ClassVar[str] = "K"
    sizes: ClassVar[tuple[float, float, float]] = (0.3, 0.8, 1.8)
    channels: ClassVar[tuple[str, ...]] = THERMOMETERS

    def draw(self, rng: np.random.Generator) -> None:
        """Choose the sign."""
        self.more["sign"] = 1.0 if rng.random() < 0.5 else -1.0

    def record(self, number: int, drive: Drive, shown: pd.DataFrame) -> None:
        """Add what has grown so far."""
        grown: Array = drive.time_s / (8.0 * 3600.0)
        shown[f"{self.channel}_degC"] += self.more["sign"] * self.size * grown
