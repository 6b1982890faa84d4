"""Effects on where the nose is, and on what its sensors stand on."""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar

import numpy as np

from benchmarks.gap import hidden
from benchmarks.gap.belt.machine import Machine
from benchmarks.gap.drive import Array, Drive, lagged
from benchmarks.gap.hidden import E, Hidden, X, Y


class ColumnBending(Hidden):
    """One wall of the column follows column minus hall late, and bends it; urad per K."""

    unit: ClassVar[str] = "urad/K"
    sizes: ClassVar[tuple[float, float, float]] = (4.0, 10.0, 25.0)

    drawn: ClassVar[Mapping[str, tuple[float, float]]] = {
        "tau_h": (0.6, 3.0),
        "lever_mm": (400.0, 800.0),
        "direction_rad": (-np.pi, np.pi),
    }

    def move(self, machine: Machine, drive: Drive, temperatures: Array, pose: Array) -> None:
        """Carry the nose along."""
        upper = temperatures[:, machine.parts["column_top"]].mean(axis=1)
        head = temperatures[:, machine.parts["headstock"]].mean(axis=1)
        late = lagged(
            drive.time_s, 0.6 * upper + 0.4 * head - drive.at(), 3600.0 * self.more["tau_h"]
        )
        shift = self.size * (late - late[0]) * self.more["lever_mm"] * 1e-3
        pose[:, X] += np.cos(self.more["direction_rad"]) * shift
        pose[:, Y] += np.sin(self.more["direction_rad"]) * shift


class SlowStructure(Hidden):
    """The bed follows the hall over many hours and carries the work away; um per K."""

    unit: ClassVar[str] = "um/K"
    sizes: ClassVar[tuple[float, float, float]] = (4.0, 9.0, 20.0)

    def draw(self, rng: np.random.Generator) -> None:
        """Choose time constant and direction."""
        self.more["tau_h"] = float(rng.uniform(3.0, 10.0))
        direction = rng.normal(size=3)
        direction /= np.linalg.norm(direction)
        for name, value in zip("xyz", direction.tolist(), strict=True):
            self.more[f"along_{name}"] = value

    def move(self, machine: Machine, drive: Drive, temperatures: Array, pose: Array) -> None:
        """Shift the nose."""
        late = lagged(drive.time_s, drive.at() - drive.at()[0], 3600.0 * self.more["tau_h"])
        for axis, name in ((X, "x"), (Y, "y"), (E, "z")):
            pose[:, axis] += self.size * self.more[f"along_{name}"] * late


class FixtureWarming(hidden.FixtureWarming):
    """The bracket stands beside the flange."""

    sizes: ClassVar[tuple[float, float, float]] = (0.8, 2.0, 5.0)
    drawn: ClassVar[Mapping[str, tuple[float, float]]] = {
        "tau_h": (0.2, 1.0),
        "of_nose": (0.1, 0.4),
        "direction_rad": (-np.pi, np.pi),
    }
