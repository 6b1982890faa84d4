"""Effects in the bearings."""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar

import numpy as np
from scipy.sparse import csc_matrix, diags
from scipy.sparse.linalg import splu

from benchmarks.gap import hidden
from benchmarks.gap.belt.grouped import BEARINGS
from benchmarks.gap.belt.laws import walther
from benchmarks.gap.belt.machine import TOP_SPEED, Machine
from benchmarks.gap.belt.numbers import FRONT_AT
from benchmarks.gap.drive import Array, Drive
from benchmarks.gap.hidden import Hidden, X, Y
from benchmarks.gap.march import Now


def _rings(now: Now, which: str) -> Array:
    return np.array([now.mean(f"{name}_{which}") for name in BEARINGS])


class ViscosityTemperature(Hidden):
    """The grease's oil thins by Walther's equation; the film is as warm as ring and balls.

    The size is how fast it thins at 50 degC, where it is as thick as without.
    """

    unit: ClassVar[str] = "1/K"
    sizes: ClassVar[tuple[float, float, float]] = (0.012, 0.025, 0.045)
    at_degc: ClassVar[float] = 50.0

    def begin(self, machine: Machine, drive: Drive) -> None:
        """Find the thin end of an oil that thins so fast at 50 degC."""
        low, high = 2.0, 99.0
        for _ in range(50):
            middle = (low + high) / 2.0
            slope = np.log(walther(100.0, middle, 49.5) / walther(100.0, middle, 50.5))
            low, high = (low, middle) if slope < self.size else (middle, high)
        self._thin = (low + high) / 2.0

    def friction(self, now: Now, viscous: Array, load: Array) -> tuple[Array, Array]:
        """Return the heat at the viscosity that the film has."""
        if self.size == 0.0:
            return viscous, load
        film = 0.6 * _rings(now, "inner") + 0.4 * _rings(now, "balls")
        usual = walther(100.0, self._thin, self.at_degc)
        nu = [walther(100.0, self._thin, float(t)) / usual for t in np.clip(film, -10.0, 150.0)]
        warm, _ = now.machine.friction(now.speed, now.machine.p["viscosity"] * np.array(nu))
        return warm, load


class ThermalPreload(Hidden):
    """The inner ring outgrows the outer; the load grows with the power 1.5 of what is taken up.

    The size is the share by which the load grows with the first kelvin.
    """

    unit: ClassVar[str] = "1/K"
    sizes: ClassVar[tuple[float, float, float]] = (0.05, 0.12, 0.3)
    most: ClassVar[float] = 8.0

    def friction(self, now: Now, viscous: Array, load: Array) -> tuple[Array, Array]:
        """Return the load-dependent heat at the preload of now."""
        warmer = np.maximum(_rings(now, "inner") - _rings(now, "outer"), 0.0)
        return viscous, load * np.minimum((1.0 + self.size / 1.5 * warmer) ** 1.5, self.most)


class FrictionSpeedExponent(hidden.FrictionSpeedExponent):
    """Equal to the usual at 5,000 r/min."""

    usual_at_rpm: ClassVar[float] = 5e3


class BearingRunIn(hidden.BearingRunIn):
    """Grease, until it has found its place."""

    sizes: ClassVar[tuple[float, float, float]] = (0.1, 0.25, 0.6)
    drawn: ClassVar[Mapping[str, tuple[float, float]]] = {"tau_h": (0.7, 3.0)}


class JointResistance(Hidden):
    """The seats of the outer rings conduct by how tightly the ring fits: G0 (1 + k dT).

    dT is the ring's warming against the housing around it; G0 over that where the seat opens.
    """

    unit: ClassVar[str] = "1/K"
    sizes: ClassVar[tuple[float, float, float]] = (0.06, 0.2, 0.6)

    def draw(self, rng: np.random.Generator) -> None:
        """Choose whether the seats tighten or open."""
        self.more["sign"] = 1.0 if rng.random() < 0.6 else -1.0

    def begin(self, machine: Machine, drive: Drive) -> None:
        """Find the housing behind each seat."""
        self._behind = {name: -machine.matrices[f"seat_{name}"] for name in BEARINGS}

    def scales(self, now: Now) -> dict[str, float]:
        """Return the factors of both seats."""
        found = {}
        for name, matrix in self._behind.items():
            ring = int(now.machine.parts[f"{name}_outer"][0])
            conductance = float(matrix[ring, ring])
            warmer = float((matrix @ now.temperature)[ring]) / conductance
            tight = 1.0 + self.size * max(warmer, 0.0)
            factor = tight if self.more["sign"] > 0.0 else 1.0 / tight
            found[f"seat_{name}"] = float(np.clip(factor, 0.25, 4.0))
        return found


class UnevenBearingHeating(Hidden):
    """The belt's pull loads one side of the front bearings: there its outer rings heat more.

    The size is the amplitude of the cosine around the axis, of the heat of the outer rings. The
    housing's temperature then has a cosine of its own, which bends it and which two thermometers
    on opposite sides see.
    """

    unit: ClassVar[str] = "1"
    sizes: ClassVar[tuple[float, float, float]] = (0.15, 0.35, 0.8)

    drawn: ClassVar[Mapping[str, tuple[float, float]]] = {"direction_rad": (0.0, 2.0 * np.pi)}

    def begin(self, machine: Machine, drive: Drive) -> None:
        """Forget the heat of the run before."""
        self._times = [float(drive.time_s[0])]
        self._watts = [0.0]

    def friction(self, now: Now, viscous: Array, load: Array) -> tuple[Array, Array]:
        """Note the heat."""
        self._now = float(viscous[0] + load[0]) * (1.0 - now.machine.p["inner_share"])
        return viscous, load

    def advance(self, now: Now, step: float) -> None:
        """Remember it."""
        self._times.append(now.time)
        self._watts.append(self._now if now.speed > 0.0 else 0.0)

    def move(self, machine: Machine, drive: Drive, temperatures: Array, pose: Array) -> None:
        """Bend the housing between the mounting face and the front bearings."""
        self._shown = self._cosine(machine, drive)
        p, d = machine.p, machine.drawing
        weights = machine.housing.mean_over(0.0, FRONT_AT)
        radius = (d.housing[-1].outer + d.housing[-1].inner) / 4.0
        # Curvature alpha T1 / r over the length, on the lever from its middle to the gauge line.
        angle = p["alpha_iron"] / radius * (self._shown @ weights)
        shift = angle * (d.gauge_line - FRONT_AT / 2.0) * 1e-3
        pose[:, X] -= np.cos(self.more["direction_rad"]) * shift
        pose[:, Y] -= np.sin(self.more["direction_rad"]) * shift

    def _cosine(self, machine: Machine, drive: Drive) -> Array:
        """Return the cosine's amplitude in the housing, shape (rows, nodes)."""
        p, solid = machine.p, machine.housing
        numbers = machine.parts["housing"]
        stiff = p["k_iron"] * (solid.conduction + solid.around)
        lost = np.zeros(len(numbers))
        for group in ("clamp", "film_housing"):
            lost -= machine.matrices[group].diagonal()[numbers]
        matrix = csc_matrix(stiff + diags(lost))
        capacity = machine.capacity[numbers]
        entry = np.zeros(len(numbers))
        for start, end in machine.drawing.front:
            nodes, area = solid.surface("inner", start, end)
            entry[nodes] += area
        entry *= self.size / entry.sum()
        step = 30.0
        solver = splu(csc_matrix(diags(capacity / step) + matrix))
        grid = np.arange(drive.time_s[0], drive.time_s[-1] + step, step)
        watts = np.interp(grid, self._times, self._watts)
        state, found = np.zeros(len(numbers)), []
        for heat in watts.tolist():
            found.append(state)
            state = solver.solve(capacity / step * state + heat * entry)
        places = np.clip((drive.time_s - grid[0]) / step, 0.0, len(grid) - 1.0)
        low = np.minimum(places.astype(int), len(grid) - 2)
        share = (places - low)[:, None]
        values = np.array(found)
        return np.asarray((1.0 - share) * values[low] + share * values[low + 1])

    def record(self, number: int, machine: Machine, drive: Drive, shown: object) -> None:
        """Show both sides at the front."""
        numbers = machine.parts["housing"]
        seen = self._shown @ machine.thermometers["front"][numbers]
        up = np.sin(self.more["direction_rad"])
        shown["front_degC"] += up * seen  # type: ignore[index]
        shown["front_below_degC"] -= up * seen  # type: ignore[index]


class CentrifugalShift(hidden.CentrifugalShift):
    """At 8,000 r/min."""

    sizes: ClassVar[tuple[float, float, float]] = (2.0, 6.0, 15.0)
    top_rpm: ClassVar[float] = TOP_SPEED


class BearingStickSlip(hidden.BearingStickSlip):
    """The rear bearing floats."""

    sizes: ClassVar[tuple[float, float, float]] = (2.5, 6.0, 12.0)
    left: ClassVar[float] = 0.2
    pushed: ClassVar[float] = 0.7

    def apart(self, machine: Machine, temperatures: Array) -> Array:
        """Return how far shaft and housing have grown apart [um]."""
        p, parts = machine.p, machine.parts
        start, end = machine.drawing.rear[0][0], FRONT_AT
        shaft = temperatures[:, parts["shaft"]] @ machine.shaft.mean_over(start, end)
        housing = temperatures[:, parts["housing"]] @ machine.housing.mean_over(start, end)
        return np.asarray((p["alpha_steel"] * shaft - p["alpha_iron"] * housing) * 1e-3)
