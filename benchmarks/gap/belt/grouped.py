"""A machine made of groups of conductances, with two sets of bearings: this one, and the lathe."""

from __future__ import annotations

from functools import cached_property
from typing import ClassVar

import numpy as np
from scipy.sparse import csr_matrix

from benchmarks.gap.belt.groups import Groups
from benchmarks.gap.belt.laws import viscous_torque, watts
from benchmarks.gap.cells import Array
from benchmarks.gap.numbers import Numbers

BEARINGS = ("front", "rear")


class Grouped:
    """A machine whose numbers are known; what it is made of is put into ``net``.

    Parameters
    ----------
    numbers : dict of str to float
    """

    still: ClassVar[tuple[str, ...]]
    """Groups of films that drafts act on."""
    by_speed: ClassVar[tuple[str, ...]] = ()
    """Groups that are not there at rest, or that speed scales."""
    counts: tuple[int, int]
    diameters: tuple[float, float]
    """Bearings of the front and the rear set, and their mean diameters [mm]."""

    def __init__(self, numbers: Numbers) -> None:
        self.p, self.net = numbers, Groups()

    def close(self) -> None:
        """Take in what the net holds now."""
        self.parts, self.capacity = self.net.parts, self.net.capacity
        self.matrices = {name: self.net.matrix(name) for name in self.net.names}
        self.to_hall = {name: self.net.hall(name) for name in self.net.names}

    def factors(self, speed: float) -> dict[str, float]:
        """Return the factor of every group of ``by_speed`` at a speed."""
        return {}

    def conductance(self, speed: float, scales: dict[str, float]) -> tuple[csr_matrix, Array]:
        """Return heat per kelvin of unknowns and of the hall [W/K] at a speed, groups scaled."""
        factors = self.factors(speed)
        inner, outer = self._fixed
        for group in dict.fromkeys((*self.by_speed, *scales)):
            scale = scales.get(group, 1.0)
            extra = factors[group] * scale if group in factors else scale - 1.0
            inner = inner + extra * self.matrices[group]
            outer = outer + extra * self.to_hall[group]
        return inner, outer

    @cached_property
    def _fixed(self) -> tuple[csr_matrix, Array]:
        names = [name for name in self.matrices if name not in self.by_speed]
        inner = csr_matrix((len(self.capacity), len(self.capacity)))
        for name in names:
            inner = inner + self.matrices[name]
        return inner, np.sum([self.to_hall[name] for name in names], axis=0)

    def friction(self, speed: float, viscosity: Array | None = None) -> tuple[Array, Array]:
        """Return viscous and load-dependent heat of the front and the rear set [W]."""
        p = self.p
        viscous, load = np.zeros(2), np.zeros(2)
        for i, name in enumerate(BEARINGS):
            nu = p["viscosity"] if viscosity is None else float(viscosity[i])
            torque = viscous_torque(p[f"f0_{name}"], nu, speed, self.diameters[i])
            viscous[i] = self.counts[i] * watts(speed, torque)
            pressed = p[f"f1_{name}"] * p[f"preload_{name}"] * self.diameters[i]
            load[i] = self.counts[i] * watts(speed, pressed)
        return viscous, load

    def take_from_air(self, gained: Array, out: Array) -> None:
        """Take from the air inside what surfaces there gain [W]; here, none are."""

    def rings(self, temperatures: Array, which: str) -> Array:
        """Return the means of both sets' inner rings, balls or outer rings [degC]."""
        return np.array([temperatures[self.parts[f"{name}_{which}"]].mean() for name in BEARINGS])

    @cached_property
    def bearing_entry(self) -> Array:
        """Where each set's heat enters, shape (unknowns, 2)."""
        entry = np.zeros((len(self.capacity), 2))
        for i, name in enumerate(BEARINGS):
            entry[self.parts[f"{name}_inner"], i] = self.p["inner_share"]
            entry[self.parts[f"{name}_outer"], i] = 1.0 - self.p["inner_share"]
        return entry
