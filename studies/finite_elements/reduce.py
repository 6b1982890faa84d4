"""The finite-element spindle reduced to a few states, cheap enough for fitting and for a control.

Galerkin projection: T = T_start + V x, with V orthonormal in the mass matrix, so that
dx/dt = -A(n) x + forcing with a small symmetric A.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.sparse.linalg import eigsh, splu

from studies.finite_elements.mesh import Array
from studies.finite_elements.spindle import FiniteElementSpindle

SLOW_MODES = 2
"""Number of slowest modes taken from each sampled speed; the others settle within seconds. Set on
no data."""
SHIFTS_S = (40.0, 300.0)
"""Times of the step responses to each source that complement the steady ones, approximately [s]:
set on no data."""
NEGLIGIBLE = 1e-6
"""Share of the largest direction's energy below which there is only rounding, given by arithmetic
[1]."""


@dataclass(frozen=True)
class ReducedRegime:
    """The reduced spindle near one speed.

    Attributes
    ----------
    speed : float
        [r/min]
    rates : array, shape (r,)
        Rates of the modes [1/s].
    vectors : array, shape (r, r)
        Orthonormal; columns are the modes in the coordinates x.
    boundaries : array, shape (2, r)
        Forcing per kelvin of air and coolant, in the coordinates x.
    """

    speed: float
    rates: Array
    vectors: Array
    boundaries: Array


class ReducedSpindle:
    """A spindle in r coordinates for a list of speeds.

    Parameters
    ----------
    spindle : FiniteElementSpindle
    size : int
        Number of coordinates r.
    speeds : sequence of float
        Speeds of the regimes; any speed belongs to the nearest [r/min].

    Attributes
    ----------
    basis : array, shape (nodes, r)
        V.
    entries : array, shape (sources, r)
        Forcing per watt of each source.
    growth, body : array, shape (r,)
        Nose displacement [um] and mean temperature [K] of the whole spindle per coordinate.
    """

    def __init__(self, spindle: FiniteElementSpindle, size: int, speeds: Sequence[float]) -> None:
        self.spindle, self.speeds = spindle, tuple(float(n) for n in speeds)
        heat = spindle.heat
        self.basis = _basis(spindle, size)
        v = self.basis
        self._groups = [
            {
                name: (v.T @ (matrix @ v), v.T @ to_air)
                for name, (matrix, to_air) in heat.groups(speed).items()
            }
            for speed in self.speeds
        ]
        self._coolant = v.T @ heat.coolant
        self.entries: Array = heat.entries.T @ v
        self.growth: Array = spindle.growth_row @ v
        ones = heat.mass @ np.ones(heat.basis.N)
        self.body: Array = (ones / ones.sum()) @ v

    def regimes(
        self, *, air: float = 1.0, coolant: float = 1.0, capacity: float = 1.0
    ) -> list[ReducedRegime]:
        """Return the modes with films, jackets and heat capacities scaled [1].

        Forcing by sources must also be divided by *capacity*.

        Parameters
        ----------
        air, coolant, capacity : float
            Factors on the films to air, on the jackets' films and on the heat capacities [1].
        """
        regimes = []
        for speed, groups in zip(self.speeds, self._groups, strict=True):
            whole = groups["conduction"][0] + air * groups["air"][0]
            whole = (whole + coolant * groups["coolant"][0]) / capacity
            rates, vectors = np.linalg.eigh((whole + whole.T) / 2.0)
            forcing = np.stack([air * groups["air"][1], coolant * self._coolant]) / capacity
            regimes.append(ReducedRegime(speed, np.maximum(rates, 1e-12), vectors, forcing))
        return regimes


def _basis(spindle: FiniteElementSpindle, size: int) -> Array:
    """Return the *size* most important vectors, orthonormal in the mass matrix.

    Snapshots: the slowest modes, steady and early responses to every source and boundary, at rest
    and turning.
    """
    heat = spindle.heat
    mass = heat.mass.tocsc()
    fields: list[Array] = []
    for speed in (0.0, 5e3, 20e3):
        matrix, to_air = heat.conductance(speed)
        drives = np.column_stack([heat.entries, to_air, heat.coolant])
        drives = drives[:, np.abs(drives).sum(axis=0) > 0.0]
        fields.append(splu(matrix).solve(drives))
        fields += [splu((matrix + mass / after).tocsc()).solve(drives) for after in SHIFTS_S]
        # A fixed start makes results reproducible.
        first = np.ones(len(to_air))
        count = min(SLOW_MODES, len(to_air) - 1)
        _, modes = eigsh(matrix, k=count, M=mass, sigma=0.0, v0=first)
        fields.append(modes)
    snapshots = np.column_stack(fields)
    snapshots = snapshots / np.sqrt(np.einsum("ij,ij->j", snapshots, mass @ snapshots))
    gram = snapshots.T @ (mass @ snapshots)
    values, vectors = np.linalg.eigh((gram + gram.T) / 2.0)
    order = np.argsort(values)[::-1][:size]
    order = order[values[order] > NEGLIGIBLE * values[order[0]]]
    return np.asarray(snapshots @ vectors[:, order] / np.sqrt(values[order]))
