"""Time stepping: the linearly implicit method ROS2, whose matrix holds conduction alone.

Two stages with gamma = 1 - 1/sqrt(2), of second order whatever the matrix leaves out, and L-stable
for what it holds: Verwer, Spee, Blom and Hundsdorfer, SIAM J. Sci. Comput. 20 (1999) 1456-1480,
doi:10.1137/S1064827597326651.
"""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csc_matrix, csr_matrix, diags
from scipy.sparse.linalg import SuperLU, splu

from benchmarks.gap.belt.drive import Drive
from benchmarks.gap.belt.machine import Machine

if TYPE_CHECKING:
    from benchmarks.gap.enclosed import Hidden

Array = NDArray[np.float64]

GAMMA = 1.0 - 0.5**0.5
STEPS = ((60.0, 5.0), (900.0, 15.0), (float("inf"), 30.0))
"""After something is switched: until when [s], in which steps [s]."""

SCALE_STEP = 0.02
MOST_KEPT = 120


class Now:
    """The machine at one instant of a run.

    Attributes
    ----------
    time, speed, feed, torque : float
        [s, r/min, mm/min, Nm]
    temperature : array, shape (unknowns,)
    hall, draft, wobble : float
        [degC, 1, 1]
    """

    def __init__(self, machine: Machine, drive: Drive, temperature: Array) -> None:
        self.machine, self.drive = machine, drive
        self.time, self.temperature = float(drive.time_s[0]), temperature
        self.speed = self.feed = self.torque = 0.0
        self._begin, self._step = float(drive.grid_s[0]), float(drive.grid_s[1] - drive.grid_s[0])
        self.look()

    def look(self) -> None:
        """Look up what is outside now."""
        place = (self.time - self._begin) / self._step
        outside = self.drive.outside
        row = min(max(int(place), 0), len(outside) - 2)
        values = outside[row] + (place - row) * (outside[row + 1] - outside[row])
        self.hall, self.draft, self.wobble = (float(value) for value in values)

    def mean(self, part: str) -> float:
        """Return the mean temperature of a part's unknowns [degC]."""
        return float(self.temperature[self.machine.parts[part]].mean())


@dataclass
class KeptFactors:
    """What stays while speed, conductances and step do."""

    factors: SuperLU
    inner: csr_matrix
    hall: Array


class March:
    """Steps one machine; keeps the factors of the conditions it has met, from run to run."""

    def __init__(self, machine: Machine, effects: Sequence[Hidden] = (), refine: int = 1) -> None:
        self.machine, self.effects, self._refine = machine, list(effects), refine
        self._kept: OrderedDict[tuple[object, ...], KeptFactors] = OrderedDict()
        self._capacity = machine.capacity
        films = [(machine.matrices[name], machine.to_hall[name]) for name in machine.still]
        self._films = sum(one for one, _ in films), np.sum([one for _, one in films], axis=0)

    def run(self, drive: Drive, start: Array) -> Array:
        """Return temperatures at the rows of *drive*, shape (rows, unknowns)."""
        now = self._begin(drive, start)
        times, states = [now.time], [now.temperature]
        for first, last in drive.segments():
            self._switch(now, first)
            for step in self._steps(float(drive.time_s[last] - drive.time_s[first])):
                self._step(now, step)
                times.append(now.time)
                states.append(now.temperature)
        return _interpolated(np.array(times), np.array(states), drive.time_s)

    def settle(self, drive: Drive, start: Array, step: float) -> Array:
        """Return temperatures at the end of *drive*, in long steps."""
        now = self._begin(drive, start)
        for first, last in drive.segments():
            self._switch(now, first)
            length = float(drive.time_s[last] - drive.time_s[first])
            count = max(1, round(length / step))
            for _ in range(count):
                self._step(now, length / count)
        return now.temperature

    def _begin(self, drive: Drive, start: Array) -> Now:
        for effect in self.effects:
            effect.begin(self.machine, drive)
        return Now(self.machine, drive, start.copy())

    def _switch(self, now: Now, row: int) -> None:
        drive = now.drive
        now.speed, now.feed = float(drive.speed[row]), float(drive.feed[row])
        now.torque = float(drive.torque[row])
        self._friction = self.machine.friction(now.speed)

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
        kept = self._factors_at(now.speed, step, scales)
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
        t, drive = now.temperature, now.drive
        hall = now.hall
        heat = np.asarray(kept.inner @ t) + kept.hall * hall
        heat += now.draft * (self._films[0] @ t + self._films[1] * hall)
        if now.speed > 0.0:
            viscous, load = self._friction
            for effect in self.effects:
                viscous, load = effect.friction(now, viscous, load)
            wobble = drive.friction_factor * (1.0 + now.wobble)
            heat += self.machine.bearing_entry @ (wobble * (viscous + load))
        self.machine.add_driven(drive.belt_factor * now.speed, abs(now.feed), heat)
        for effect in self.effects:
            effect.heat(now, heat)
        return heat

    def _factors_at(self, speed: float, step: float, scales: dict[str, float]) -> KeptFactors:
        rounded = {g: round(s / SCALE_STEP) * SCALE_STEP for g, s in scales.items()}
        key = (speed, round(step, 6), tuple(sorted(rounded.items())))
        found = self._kept.get(key)
        if found is None:
            inner, hall = self.machine.conductance(speed, rounded)
            matrix = csc_matrix(diags(self._capacity) - GAMMA * step * inner)
            found = self._kept[key] = KeptFactors(splu(matrix), inner, hall)
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
