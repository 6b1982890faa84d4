"""Time stepping: conduction implicit, everything else explicit, both of second order.

ARS(2,2,2) of Ascher, Ruuth and Spiteri, Appl. Numer. Math. 25 (1997) 151,
doi:10.1016/S0168-9274(97)00056-1; its implicit part is L-stable.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.linalg import inv

from benchmarks.gap.drive import Array
from benchmarks.gap.hidden import Hidden
from benchmarks.gap.march import Now, Stepper
from benchmarks.gap.truth.spindle import Spindle

GAMMA = 1.0 - 0.5**0.5
DELTA = 1.0 - 1.0 / (2.0 * GAMMA)


@dataclass
class KeptMatrices:
    """What stays while speed, conductances and step do."""

    inverse: Array
    boundary: Array


class March(Stepper[KeptMatrices]):
    """Steps one jig borer."""

    steps = ((30.0, 2.5), (240.0, 10.0), (float("inf"), 20.0))
    scale_step = 0.005
    most_kept = 80

    def __init__(self, machine: Spindle, effects: Sequence[Hidden] = (), refine: int = 1) -> None:
        super().__init__(machine, effects, refine)
        self._motor = machine.drive_entry() * machine.p["motor"] * 1e-3
        self._surfaces = [
            (cells, which, g)
            for group, parts in machine.surfaces.items()
            if group != "film_bed"
            for cells, which, g in parts
        ]

    def step(self, now: Now, step: float) -> None:
        """Go on by a step [s]."""
        kept = self.kept_at(now, step)
        begin, t0 = now.time, now.temperature
        f0 = self._rate(now, kept)
        h = step * GAMMA
        first = kept.inverse @ (t0 + h * f0)
        conduction = (first - t0) / h - f0
        now.time, now.temperature = begin + h, first
        f1 = self._rate(now, kept)
        rest = step * (DELTA * f0 + (1.0 - DELTA) * f1 + (1.0 - GAMMA) * conduction)
        now.temperature = kept.inverse @ (t0 + rest)
        now.time = begin + step
        for effect in self.effects:
            effect.advance(now, step)

    def _rate(self, now: Now, kept: KeptMatrices) -> Array:
        """Return what warms the cells besides conduction between them [K/s]."""
        boundary = now.look()
        for effect in self.effects:
            effect.boundaries(now, boundary)
        heat = kept.boundary @ boundary
        t = now.temperature
        for cells, which, g in self._surfaces:
            heat[cells] += (now.draft * g) * (boundary[which] - t[cells])
        if now.speed > 0.0:
            heat += self.friction(now)
            heat += (now.drive.drive_factor * now.speed) * self._motor
        for effect in self.effects:
            effect.heat(now, heat)
        return np.asarray(heat / self._capacity)

    def factors(self, speed: float, step: float, scales: dict[str, float]) -> KeptMatrices:
        """Return the inverse of the implicit part, and what boundaries give."""
        inner, outer = self.machine.conductances(speed, scales)
        matrix = (-step * GAMMA) * inner / self._capacity[:, None]
        matrix[np.diag_indices_from(matrix)] += 1.0
        inverse = np.ascontiguousarray(inv(matrix, overwrite_a=True, check_finite=False))
        return KeptMatrices(inverse, outer)
