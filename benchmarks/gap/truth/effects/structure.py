"""Effects on where the nose is, that no temperature of the spindle shows."""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar

import numpy as np

from benchmarks.gap import hidden
from benchmarks.gap.drive import Array, Drive, lagged
from benchmarks.gap.hidden import E, Hidden, X, Y
from benchmarks.gap.truth.spindle import POSE, Spindle

YAW, PITCH = (POSE.index(name) for name in ("yaw", "pitch"))


class ColumnBending(Hidden):
    """The column's skin follows structure minus air late, and bends it; urad per K."""

    unit: ClassVar[str] = "urad/K"
    sizes: ClassVar[tuple[float, float, float]] = (4.0, 9.0, 20.0)

    drawn: ClassVar[Mapping[str, tuple[float, float]]] = {
        "tau_h": (0.6, 3.0),
        "lever_mm": (450.0, 750.0),
        "direction_rad": (0.2, 1.4),
    }

    def move(self, spindle: Spindle, drive: Drive, temperatures: Array, pose: Array) -> None:
        """Tilt the nose and carry it along."""
        structure = 0.5 * (
            temperatures[:, spindle.parts["pedestal"]].mean(axis=1)
            + temperatures[:, spindle.parts["column"]].mean(axis=1)
        )
        late = lagged(drive.time_s, structure - drive.at(1), 3600.0 * self.more["tau_h"])
        tilt = self.size * (late - late[0])
        arm = self.more["lever_mm"] * 1e-3
        for shift, angle, share in (
            (X, YAW, np.cos(self.more["direction_rad"])),
            (Y, PITCH, np.sin(self.more["direction_rad"])),
        ):
            pose[:, angle] += share * tilt
            pose[:, shift] += share * arm * tilt


class SlowStructure(Hidden):
    """The bed follows hall and base over many hours and carries the spindle away; um per K."""

    unit: ClassVar[str] = "um/K"
    sizes: ClassVar[tuple[float, float, float]] = (4.0, 9.0, 20.0)

    def draw(self, rng: np.random.Generator) -> None:
        """Choose time constant and direction."""
        self.more["tau_h"] = float(rng.uniform(3.0, 10.0))
        direction = rng.normal(size=3)
        direction[2] += np.sign(direction[2])
        direction /= np.linalg.norm(direction)
        for name, value in zip("xyz", direction.tolist(), strict=True):
            self.more[f"along_{name}"] = value

    def move(self, spindle: Spindle, drive: Drive, temperatures: Array, pose: Array) -> None:
        """Shift the nose without tilting it."""
        base = temperatures[:, spindle.parts["pedestal"]].mean(axis=1)
        follows = 0.5 * (drive.at(1) - drive.at(1)[0]) + 0.5 * (base - base[0])
        late = lagged(drive.time_s, follows, 3600.0 * self.more["tau_h"])
        for axis, name in ((X, "x"), (Y, "y"), (E, "z")):
            pose[:, axis] += self.size * self.more[f"along_{name}"] * late


class CentrifugalShift(hidden.CentrifugalShift):
    """At 20,000 r/min."""

    sizes: ClassVar[tuple[float, float, float]] = (3.0, 7.0, 18.0)
    top_rpm: ClassVar[float] = 20e3


class BearingStickSlip(hidden.BearingStickSlip):
    """The rear bearing floats."""

    sizes: ClassVar[tuple[float, float, float]] = (3.0, 7.0, 15.0)
    left: ClassVar[float] = 0.15
    pushed: ClassVar[float] = 0.8

    def apart(self, machine: Spindle, temperatures: Array) -> Array:
        """Return how far shaft and housing have grown apart [um]."""
        rise = temperatures - temperatures[0]
        layout, parts = machine.layout, machine.parts
        steel = machine.p["alpha_steel"] * 1e-3
        span = 375.0
        shaft = rise[:, parts["shaft"]] @ layout.share("shaft", -75.0, 300.0)
        housing = rise[:, parts["housing"]].mean(axis=2) @ layout.share("housing", -75.0, 300.0)
        return np.asarray(steel * span * (shaft - housing))
