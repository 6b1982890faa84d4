"""Effects in the bearings: those of the belt-driven spindle, whose parts have the same names."""

from __future__ import annotations

from typing import ClassVar

from benchmarks.gap.belt.effects import bearings
from benchmarks.gap.belt.effects.bearings import (
    BearingRunIn,
    FrictionSpeedExponent,
    ViscosityTemperature,
)

__all__ = ["BearingRunIn", "FrictionSpeedExponent", "ViscosityTemperature"]


class ThermalPreload(bearings.ThermalPreload):
    """The bearings of a lathe are larger and stiffer."""

    sizes: ClassVar[tuple[float, float, float]] = (0.1, 0.25, 0.6)


class JointResistance(bearings.JointResistance):
    """They sit in a headstock that hardly lags behind them."""

    sizes: ClassVar[tuple[float, float, float]] = (0.1, 0.3, 0.7)
