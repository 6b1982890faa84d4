"""Time stepping: conduction implicit, everything else explicit, both of second order.

ARS(2,2,2) of Ascher, Ruuth and Spiteri, Appl. Numer. Math. 25 (1997) 151,
doi:10.1016/S0168-9274(97)00056-1; its implicit part is L-stable.
"""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import inv

from benchmarks.gap.truth.drive import Drive
from benchmarks.gap.truth.effects.base import Hidden, Now
from benchmarks.gap.truth.spindle import Spindle

Array = NDArray[np.float64]

GAMMA = 1.0 - 0.5**0.5
DELTA = 1.0 - 1.0 / (2.0 * GAMMA)
STEPS = ((30.0, 2.5), (240.0, 10.0), (float("inf"), 20.0))
"""After a change of speed: until when [s], in which steps [s]."""
SCALE_STEP = 0.005
MOST_KEPT = 80


@dataclass
class KeptMatrices:
    """What stays while speed, conductances and step do."""

    step: float
    inverse: Array
    boundary: Array


class March:
    """Steps one machine; keeps the matrices of the conditions it has met, from run to run."""

    def __init__(self, spindle: Spindle, effects: Sequence[Hidden] = (), refine: int = 1) -> None:
        self.spindle, self.effects, self._refine = spindle, list(effects), refine
        self._kept: OrderedDict[tuple[object, ...], KeptMatrices] = OrderedDict()
        self._capacity = spindle.capacity
        self._motor = spindle.motor_entry() * spindle.p["motor"] * 1e-3
        self._surfaces = [
            (cells, which, g)
            for group, parts in spindle.surfaces.items()
            if group != "film_bed"
            for cells, which, g in parts
        ]

    def run(self, drive: Drive, start: Array) -> Array:
        """Return temperatures at the rows of *drive*, shape (rows, cells), from those at first."""
        for effect in self.effects:
            effect.begin(self.spindle, drive)
        now = Now(self.spindle, drive, start.copy())
        times, states = [float(drive.time_s[0])], [now.temperature]
        for first, last in drive.segments():
            now.speed, now.torque = float(drive.speed[first]), float(drive.torque[first])
            self._friction = self.spindle.friction(now.speed)
            for step in self._steps(float(drive.time_s[last] - drive.time_s[first])):
                self._step(now, step)
                times.append(now.time)
                states.append(now.temperature)
        return _interpolated(np.array(times), np.array(states), drive.time_s)

    def settle(self, drive: Drive, start: Array, step: float) -> Array:
        """Return temperatures at the end of *drive*, in long steps."""
        for effect in self.effects:
            effect.begin(self.spindle, drive)
        now = Now(self.spindle, drive, start.copy())
        for first, last in drive.segments():
            now.speed, now.torque = float(drive.speed[first]), float(drive.torque[first])
            self._friction = self.spindle.friction(now.speed)
            length = float(drive.time_s[last] - drive.time_s[first])
            count = max(1, round(length / step))
            for _ in range(count):
                self._step(now, length / count)
        return now.temperature

    def _steps(self, length: float) -> list[float]:
        steps: list[float] = []
        done = 0.0
        for until, step in STEPS:
            step /= self._refine
            while done < min(until, length) - 1e-6:
                steps.append(min(step, length - done))
                done += steps[-1]
        return steps

    def _step(self, now: Now, step: float) -> None:
        scales: dict[str, float] = {}
        for effect in self.effects:
            for group, factor in effect.scales(now).items():
                scales[group] = scales.get(group, 1.0) * factor
        kept = self._matrices_at(now.speed, step, scales)
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
        drive = now.drive
        boundary = now.look_up()
        for effect in self.effects:
            effect.boundaries(now, boundary)
        heat = kept.boundary @ boundary
        t = now.temperature
        for cells, which, g in self._surfaces:
            heat[cells] += (now.draft * g) * (boundary[which] - t[cells])
        if now.speed > 0.0:
            viscous, load = self._friction
            for effect in self.effects:
                viscous, load = effect.friction(now, viscous, load)
            wobble = drive.friction_factor * (1.0 + now.wobble)
            heat += self.spindle.bearing_entry @ (wobble * (viscous + load))
            heat += (drive.motor_factor * now.speed) * self._motor
        for effect in self.effects:
            effect.heat(now, heat)
        return np.asarray(heat / self._capacity)

    def _matrices_at(self, speed: float, step: float, scales: dict[str, float]) -> KeptMatrices:
        rounded = {g: round(s / SCALE_STEP) * SCALE_STEP for g, s in scales.items()}
        key = (speed, round(step, 6), tuple(sorted(rounded.items())))
        found = self._kept.get(key)
        if found is None:
            inner, outer = self.spindle.conductances(speed, rounded)
            matrix = (-step * GAMMA) * inner / self._capacity[:, None]
            matrix[np.diag_indices_from(matrix)] += 1.0
            inverse = np.ascontiguousarray(inv(matrix, overwrite_a=True, check_finite=False))
            found = self._kept[key] = KeptMatrices(step, inverse, outer)
            if len(self._kept) > MOST_KEPT:
                self._kept.popitem(last=False)
        else:
            self._kept.move_to_end(key)
        return found


def _interpolated(times: Array, states: Array, wanted: Array) -> Array:
    right = np.clip(np.searchsorted(times, wanted), 1, len(times) - 1)
    left = right - 1
    share = (wanted - times[left]) / (times[right] - times[left])
    return np.asarray(states[left] + share[:, None] * (states[right] - states[left]))
