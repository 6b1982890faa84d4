"""Laws of the belt-driven spindle's effects, beside those common to all simulators."""

from __future__ import annotations

from typing import Any, ClassVar

import numpy as np
import pandas as pd
from scipy.sparse import csc_matrix, diags
from scipy.sparse.linalg import splu

from benchmarks.gap import laws
from benchmarks.gap.belt.grouped import BEARINGS, Grouped
from benchmarks.gap.belt.laws import walther
from benchmarks.gap.belt.machine import Machine
from benchmarks.gap.belt.numbers import FRONT_AT
from benchmarks.gap.drive import Array, Drive, lagged
from benchmarks.gap.hidden import Hidden, X, Y
from benchmarks.gap.march import Now

# Bearings.


class ViscosityTemperature(Hidden, unit="1/K"):
    """The grease's oil thins by Walther's equation; the film is as warm as ring and balls.

    The size is how fast it thins at 50 degC, where it is as thick as without.
    """

    at_degc: ClassVar[float] = 50.0

    def begin(self, machine: Grouped, drive: Drive) -> None:
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
        machine, t = now.machine, now.temperature
        film = 0.6 * machine.rings(t, "inner") + 0.4 * machine.rings(t, "balls")
        usual = walther(100.0, self._thin, self.at_degc)
        nu = [walther(100.0, self._thin, float(t)) / usual for t in np.clip(film, -10.0, 150.0)]
        warm, _ = machine.friction(now.speed, machine.p["viscosity"] * np.array(nu))
        return warm, load


class JointResistance(laws.JointResistance):
    """The seats of the outer rings, against the housing around them."""

    def begin(self, machine: Grouped, drive: Drive) -> None:
        """Find the housing behind each seat."""
        self._behind = {name: -machine.matrices[f"seat_{name}"] for name in BEARINGS}

    def warmer(self, now: Now) -> dict[str, float]:
        """Return rings against what their seats conduct to [K]."""
        found = {}
        for name, matrix in self._behind.items():
            ring = int(now.machine.parts[f"{name}_outer"][0])
            conductance = float(matrix[ring, ring])
            found[f"seat_{name}"] = float((matrix @ now.temperature)[ring]) / conductance
        return found


class UnevenBearingHeating(Hidden, unit="1"):
    """The belt's pull loads one side of the front bearings: there its outer rings heat more.

    The size is the amplitude of the cosine around the axis, of the heat of the outer rings. The
    housing's temperature then has a cosine of its own, which bends it and which two thermometers
    on opposite sides see.
    """

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

    def record(self, number: int, machine: Machine, drive: Drive, shown: pd.DataFrame) -> None:
        """Show both sides at the front."""
        numbers = machine.parts["housing"]
        seen = self._shown @ machine.thermometers["front"][numbers]
        up = np.sin(self.more["direction_rad"])
        shown["front_degC"] += up * seen
        shown["front_below_degC"] -= up * seen


class BearingStickSlip(laws.BearingStickSlip):
    """The rear bearing floats."""

    def apart(self, machine: Machine, temperatures: Array) -> Array:
        """Return how far shaft and housing have grown apart [um]."""
        p, parts = machine.p, machine.parts
        start, end = machine.drawing.rear[0][0], FRONT_AT
        shaft = temperatures[:, parts["shaft"]] @ machine.shaft.mean_over(start, end)
        housing = temperatures[:, parts["housing"]] @ machine.housing.mean_over(start, end)
        return np.asarray((p["alpha_steel"] * shaft - p["alpha_iron"] * housing) * 1e-3)


# Turning parts and cutting.


class Windage(laws.Windage):
    """Half of it warms the shaft between the bearings, half the housing around it."""

    def entry(self, machine: Machine) -> Array:
        """Return the share of every unknown."""
        d, entry = machine.drawing, np.zeros(len(machine.capacity))
        for solid, part, side in (
            (machine.shaft, "shaft", "outer"),
            (machine.housing, "housing", "inner"),
        ):
            nodes, area = solid.surface(side, d.rear[0][1], d.front[0][0])
            entry[machine.parts[part][nodes]] += 0.5 * area / area.sum()
        return entry


class CuttingHeat(laws.CuttingHeat):
    """Most of it into the tool's tip, some into the nose."""

    def entry(self, machine: Machine) -> Array:
        """Return the share of every unknown."""
        d, entry = machine.drawing, np.zeros(len(machine.capacity))
        tip, share = machine.tool.face(d.gauge_line + d.tool_length)
        entry[machine.parts["tool"][tip]] += 0.6 * share
        nose, share = machine.shaft.face(d.gauge_line)
        entry[machine.parts["shaft"][nose]] += 0.4 * share
        return entry


class ToolHeating(laws.ToolHeating):
    """It sits on the shaft's end."""

    def seat(self, machine: Machine) -> tuple[Any, Array]:
        """Return the nodes of the shaft's face."""
        nodes, share = machine.shaft.face(machine.drawing.gauge_line)
        return machine.parts["shaft"][nodes], share


# Structure, and what happens to such machines.


class ColumnBending(Hidden, unit="urad/K"):
    """One wall of the column follows column minus hall late, and bends it; urad per K."""

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


class HydraulicPulses(laws.PartSource):
    """A hydraulic unit behind the column runs in pulses of its own; the size is its watts."""

    def watts(self, now: Now) -> float:
        """Return the power [W]."""
        pulsing = (now.time / 3600.0 / self.more["period_h"]) % 1.0 < self.more["on"]
        return self.size if pulsing else 0.0


class FloodCoolant(Hidden, unit="W/K", catalogued=False):
    """Cutting coolant runs over flange and nose by a program of its own; the size is W/K."""

    def begin(self, machine: Machine, drive: Drive) -> None:
        """Find what gets wet."""
        nodes, area = machine.housing.surface("outer", 0.0, machine.drawing.housing[-1].end)
        self._wet, self._share = machine.parts["housing"][nodes], area / area.sum()

    def heat(self, now: Now, out: Array) -> None:
        """Cool the flange."""
        if now.time > 0.0 and (now.time / 3600.0 / self.more["period_h"]) % 1.0 > 0.6:
            cold = now.hall - self.more["colder_K"]
            out[self._wet] += self.size * self._share * (cold - now.temperature[self._wet])


class SettlingFoundation(Hidden, unit="um", catalogued=False):
    """The machine tilts on its feet by an amount of its own in every run; um after eight hours."""

    def draw(self, rng: np.random.Generator) -> None:
        """Keep chance for the runs."""
        self._chance = rng

    def begin(self, machine: Machine, drive: Drive) -> None:
        """Choose this run's direction and pace."""
        self._way = float(self._chance.uniform(-np.pi, np.pi))
        self._pace = float(self._chance.uniform(0.4, 1.6))

    def move(self, machine: Machine, drive: Drive, temperatures: Array, pose: Array) -> None:
        """Move the nose sideways."""
        gone = self.size * self._pace * np.sqrt(drive.time_s / 28800.0)
        pose[:, X] += np.cos(self._way) * gone
        pose[:, Y] += np.sin(self._way) * gone
