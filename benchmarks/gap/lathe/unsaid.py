"""What the lathe has and its owner's file may not say: a tank, a fan, a disk of tools."""

from __future__ import annotations

from typing import ClassVar

from benchmarks.gap.belt.unsaid import BoltedMass, StirredNut
from benchmarks.gap.enclosed import SteadySource


class HydraulicTank(SteadySource):
    """The tank of the chuck's hydraulics stands in the left of the bed and warms it; watts."""

    sizes: ClassVar[tuple[float, float, float]] = (80.0, 200.0, 400.0)
    part: ClassVar[str] = "bed"
    cells: ClassVar[slice] = slice(8)


class FannedNut(StirredNut):
    """The moving carriage fans the nut; W/K at the highest feed."""


class ToolDisk(BoltedMass):
    """The disk of the turret hangs on the slide and follows it; its heat capacity [J/K]."""

    part: ClassVar[str] = "slide"
    conductance: ClassVar[float] = 15.0
