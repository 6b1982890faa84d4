"""Time stepping: the linearly implicit method ROS2, whose matrix holds conduction alone.

Two stages with gamma = 1 - 1/sqrt(2), of second order whatever the matrix leaves out, and L-stable
for what it holds: Verwer, Spee, Blom and Hundsdorfer, SIAM J. Sci. Comput. 20 (1999) 1456-1480,
doi:10.1137/S1064827597326651.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.sparse import csc_matrix, csr_matrix, diags
from scipy.sparse.linalg import SuperLU, splu

from benchmarks.gap.drive import Array
from benchmarks.gap.hidden import Hidden
from benchmarks.gap.march import Now, Stepper

GAMMA = 1.0 - 0.5**0.5


@dataclass
class KeptFactors:
    """What stays while speed, conductances and step do."""

    factors: SuperLU
    inner: csr_matrix
    hall: Array


class March(Stepper[KeptFactors]):
    """Steps one belt-driven spindle, or one lathe."""

    steps = ((60.0, 5.0), (900.0, 15.0), (float("inf"), 30.0))
    scale_step = 0.02
    most_kept = 120

    def __init__(self, machine: Any, effects: Sequence[Hidden] = (), refine: int = 1) -> None:
        super().__init__(machine, effects, refine)
        films = [(machine.matrices[name], machine.to_hall[name]) for name in machine.still]
        self._films = sum(one for one, _ in films), np.sum([one for _, one in films], axis=0)

    def step(self, now: Now, step: float) -> None:
        """Go on by a step [s]."""
        kept = self.kept_at(now, step)
        begin, t0 = now.time, now.temperature
        first = kept.factors.solve(self._watts(now, kept))
        now.time, now.temperature = begin + step, t0 + step * first
        now.look()
        second = kept.factors.solve(self._watts(now, kept) - 2.0 * self._capacity * first)
        now.temperature = t0 + step * (1.5 * first + 0.5 * second)
        for effect in self.effects:
            effect.advance(now, step)

    def _watts(self, now: Now, kept: KeptFactors) -> Array:
        """Return the heat that every unknown gets [W]."""
        t, hall = now.temperature, now.hall
        heat = np.asarray(kept.inner @ t) + kept.hall * hall
        heat += now.draft * (self._films[0] @ t + self._films[1] * hall)
        if now.speed > 0.0:
            heat += self.friction(now)
        self.machine.add_driven(now.drive.drive_factor * now.speed, abs(now.feed), heat)
        for effect in self.effects:
            effect.heat(now, heat)
        return heat

    def factors(self, speed: float, step: float, scales: dict[str, float]) -> KeptFactors:
        """Return the factors of the implicit part, and what conducts."""
        inner, hall = self.machine.conductance(speed, scales)
        matrix = csc_matrix(diags(self._capacity) - GAMMA * step * inner)
        return KeptFactors(splu(matrix), inner, hall)
