"""Effects on what the thermometers show."""

from __future__ import annotations

from typing import ClassVar

from benchmarks.gap import hidden

QUICK = ("front", "front_below", "rear", "nut", "inside")
THERMOMETERS = (*QUICK[:3], "headstock", "column_top", "column", *QUICK[3:])


class SensorLag(hidden.SensorLag):
    """One of the thermometers on quick parts answers late."""

    channels: ClassVar[tuple[str, ...]] = QUICK


class SensorOffset(hidden.SensorOffset):
    """One thermometer reads wrong by a constant from one run on."""

    sizes: ClassVar[tuple[float, float, float]] = (0.3, 0.8, 2.5)
    channels: ClassVar[tuple[str, ...]] = THERMOMETERS


class SensorDrift(hidden.SensorDrift):
    """One thermometer wanders away in every run."""

    sizes: ClassVar[tuple[float, float, float]] = (0.3, 0.9, 2.4)
    channels: ClassVar[tuple[str, ...]] = THERMOMETERS
