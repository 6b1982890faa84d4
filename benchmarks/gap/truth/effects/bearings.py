"""Effects in the bearings."""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar

import numpy as np

from benchmarks.gap import hidden
from benchmarks.gap.drive import Array, Drive
from benchmarks.gap.hidden import Hidden
from benchmarks.gap.march import Now
from benchmarks.gap.truth.laws import viscous_torque, vogel_factor, watts
from benchmarks.gap.truth.spindle import Spindle


def _inner(now: Now) -> Array:
    return np.asarray(now.temperature[now.machine.parts["inner"]])


def _outer(now: Now) -> Array:
    return np.asarray(now.temperature[now.machine.parts["outer"]].mean(axis=1))


class ViscosityTemperature(Hidden):
    """The oil thins by Vogel's equation; the film sits between ring and balls."""

    unit: ClassVar[str] = "1/K"
    sizes: ClassVar[tuple[float, float, float]] = (0.015, 0.03, 0.055)

    def friction(self, now: Now, viscous: Array, load: Array) -> tuple[Array, Array]:
        """Return the heat at the viscosity that the film has."""
        spindle = now.machine
        film = 0.7 * _inner(now) + 0.3 * now.temperature[spindle.parts["balls"]]
        nu = spindle.p["viscosity"] * vogel_factor(film - 25.0, self.size)
        if self.size == 0.0:
            return viscous, load
        return watts(now.speed, viscous_torque(spindle.f0, nu, now.speed)), load


class ThermalPreload(Hidden):
    """The inner ring outgrows the outer and tightens the bearing, at most eightfold."""

    unit: ClassVar[str] = "1/K"
    sizes: ClassVar[tuple[float, float, float]] = (0.04, 0.08, 0.15)
    most: ClassVar[float] = 8.0

    def friction(self, now: Now, viscous: Array, load: Array) -> tuple[Array, Array]:
        """Return the load-dependent heat at the preload of now."""
        warmer = np.maximum(_inner(now) - _outer(now), 0.0)
        return viscous, load * np.minimum(1.0 + self.size * warmer, self.most)


class FrictionSpeedExponent(hidden.FrictionSpeedExponent):
    """The usual power is 5/3."""

    usual_at_rpm: ClassVar[float] = 1e4


class BearingRunIn(hidden.BearingRunIn):
    """Oil and air: less of it than with grease."""

    sizes: ClassVar[tuple[float, float, float]] = (0.08, 0.2, 0.5)
    drawn: ClassVar[Mapping[str, tuple[float, float]]] = {"tau_h": (0.8, 3.0)}


class UnevenBearingHeating(Hidden):
    """More heat on one side of the outer rings: that share of the bearings' heat changes sides."""

    unit: ClassVar[str] = "1"
    sizes: ClassVar[tuple[float, float, float]] = (0.2, 0.4, 0.8)

    drawn: ClassVar[Mapping[str, tuple[float, float]]] = {"direction_rad": (0.0, 2.0 * np.pi)}

    def begin(self, spindle: Spindle, drive: Drive) -> None:
        """Compute where the heat moves to."""
        angles = spindle.layout.angles
        around = np.cos(angles - self.more["direction_rad"]) / len(angles)
        self._around = self.size * around

    def heat(self, now: Now, out: Array) -> None:
        """Move heat from one side to the other."""
        total = np.sum(now.machine.friction(now.speed), axis=0)
        out[now.machine.parts["outer"]] += total[:, None] * self._around


class JointResistance(Hidden):
    """The outer rings' seats conduct by how tightly the ring fits: its warming against the housing.

    G = G0 (1 + k (T_ring - T_housing)), or G0 over that where the fit opens; within a fifth and
    five times G0.
    """

    unit: ClassVar[str] = "1/K"
    sizes: ClassVar[tuple[float, float, float]] = (0.03, 0.1, 0.3)

    def draw(self, rng: np.random.Generator) -> None:
        """Choose whether the seat tightens or opens."""
        self.more["sign"] = 1.0 if rng.random() < 0.6 else -1.0

    def scales(self, now: Now) -> dict[str, float]:
        """Return the factors of both seats."""
        outer = _outer(now)
        parts, rows = now.machine.parts, now.machine.layout.middles("housing")
        housing = now.temperature[parts["housing"]].mean(axis=1)
        found = {}
        for name, ring, cells in (
            ("rear", outer[:2].mean(), rows < 0.0),
            ("front", outer[2:].mean(), rows > 180.0),
        ):
            tight = 1.0 + self.size * max(float(ring - housing[cells].mean()), 0.0)
            factor = tight if self.more["sign"] > 0.0 else 1.0 / tight
            found[f"joint_outer_{name}"] = float(np.clip(factor, 0.2, 5.0))
        return found
