"""The finite-element spindle: steady states, runs over time, growth."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.sparse.linalg import SuperLU, splu

from studies.finite_elements.description import Description, read_description
from studies.finite_elements.growth import GrowthModel
from studies.finite_elements.heat import HeatModel
from studies.finite_elements.mesh import Array, build_mesh

GAMMA = 1.0 - 0.5**0.5
"""Coefficient of the two-stage second-order scheme, given by its L-stability [1]."""


@dataclass(frozen=True)
class Transient:
    """A run over time.

    Attributes
    ----------
    time_s : array, shape (rows,)
    temperatures : array, shape (rows, nodes) [degC]
    growth_um : array, shape (rows,)
        Axial displacement of the nose since the first row.
    """

    time_s: Array
    temperatures: Array
    growth_um: Array


class FiniteElementSpindle:
    """An axisymmetric thermo-elastic spindle.

    Parameters
    ----------
    description : Description, optional
        By default the shipped one, of the size of the jig borer.
    """

    def __init__(self, description: Description | None = None) -> None:
        self.description = description or read_description()
        self.mesh = build_mesh(self.description)
        self.heat = HeatModel(self.description, self.mesh)

    @cached_property
    def growth_model(self) -> GrowthModel:
        """The elastic body."""
        return GrowthModel(self.description, self.mesh)

    @cached_property
    def growth_row(self) -> Array:
        """Nose displacement per kelvin of every node [um/K]."""
        return self.growth_model.influence()

    def steady(self, speed: float, ambient: float = 20.0, coolant: float = 20.0) -> Array:
        """Return the temperatures after a long time at one speed [degC], shape (nodes,).

        Parameters
        ----------
        speed : float
            Held forever [r/min].
        ambient, coolant : float
            Temperature of the air and of the coolant inlet [degC].
        """
        matrix, to_air = self.heat.conductance(speed)
        right = self.heat.entries @ self.heat.powers(speed)
        right = right + to_air * ambient + self.heat.coolant * coolant
        return np.asarray(splu(matrix).solve(right))

    def zss(self, speed: float) -> float:
        """Return the steady growth at a speed from a uniform start [um].

        Parameters
        ----------
        speed : float
            Held forever [r/min]; air, coolant and the start are at 20 degC.
        """
        return float(self.growth_row @ (self.steady(speed) - 20.0))

    def transient(
        self,
        time_s: Array,
        speed: Array,
        ambient: Array | float = 20.0,
        coolant: Array | float = 20.0,
        *,
        start: Array | None = None,
        longest_s: float = 60.0,
    ) -> Transient:
        """Return a run: speeds hold until the next row, outside temperatures are interpolated.

        Parameters
        ----------
        time_s, speed : array, shape (rows,)
            [s, r/min]
        ambient, coolant : array, shape (rows,), or float
            [degC]
        start : array, shape (nodes,), optional
            By default the first ambient temperature everywhere.
        longest_s : float
            Longest inner step [s].

        Notes
        -----
        Two-stage diagonally implicit Runge-Kutta, second order, L-stable, so that the fast modes
        do not ring after a stop or start.
        """
        rows = len(time_s)
        air, bath = (np.broadcast_to(np.asarray(u, float), (rows,)) for u in (ambient, coolant))
        now = np.full(self.heat.basis.N, air[0]) if start is None else start.astype(float)
        temperatures = np.empty((rows, len(now)))
        temperatures[0] = now
        solver = _Solver(self.heat)
        for k in range(rows - 1):
            length = float(time_s[k + 1] - time_s[k])
            count = max(1, int(np.ceil(length / longest_s - 1e-9)))
            step = length / count
            for i in range(count):
                ends = [
                    (_between(air, k, share), _between(bath, k, share))
                    for share in ((i + GAMMA) / count, (i + 1) / count)
                ]
                now = solver.step(now, float(speed[k]), step, *ends)
            temperatures[k + 1] = now
        growth = (temperatures - temperatures[0]) @ self.growth_row
        return Transient(np.asarray(time_s, float), temperatures, growth)


def _between(values: Array, row: int, share: float) -> float:
    return float(values[row] + share * (values[row + 1] - values[row]))


class _Solver:
    """Keeps the matrix factors of the regimes that occur."""

    def __init__(self, heat: HeatModel) -> None:
        self._heat = heat
        self._known: dict[tuple[float, float], tuple[SuperLU, Array, Array]] = {}

    def step(
        self,
        now: Array,
        speed: float,
        step: float,
        middle: tuple[float, float],
        end: tuple[float, float],
    ) -> Array:
        """Return the temperatures one step later."""
        factors, to_air, heat = self._regime(speed, step)
        mass, h = self._heat.mass, GAMMA * step

        def forcing(outside: tuple[float, float]) -> Array:
            return np.asarray(heat + to_air * outside[0] + self._heat.coolant * outside[1])

        old = mass @ now
        first = factors.solve(old + h * forcing(middle))
        slope = (mass @ first - old) / h
        return np.asarray(factors.solve(old + (step - h) * slope + h * forcing(end)))

    def _regime(self, speed: float, step: float) -> tuple[SuperLU, Array, Array]:
        key = (speed, round(step, 9))
        if key not in self._known:
            matrix, to_air = self._heat.conductance(speed)
            factors = splu((self._heat.mass + GAMMA * step * matrix).tocsc())
            heat = self._heat.entries @ self._heat.powers(speed)
            if len(self._known) > 60:
                self._known.clear()
            self._known[key] = (factors, to_air, heat)
        return self._known[key]
