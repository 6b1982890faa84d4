"""Time stepping for any simulator: from switch to switch, in steps that grow after each one."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections import OrderedDict
from collections.abc import Sequence
from typing import Any, ClassVar, Generic, TypeVar

import numpy as np

from benchmarks.gap.drive import Array, Drive
from benchmarks.gap.hidden import Hidden

Kept = TypeVar("Kept")


class Now:
    """The machine at one instant of a run.

    Attributes
    ----------
    machine : object
        Of the simulator.
    time, speed, feed, torque : float
        [s, r/min, mm/min, Nm]
    temperature : array, shape (unknowns,)
    draft, wobble : float
        Relative disturbances of the outer films and of friction.
    """

    def __init__(self, machine: Any, drive: Drive, temperature: Array) -> None:
        self.machine, self.drive = machine, drive
        self.time, self.temperature = float(drive.time_s[0]), temperature
        self.speed = self.feed = self.torque = 0.0
        self._begin, self._step = float(drive.grid_s[0]), float(drive.grid_s[1] - drive.grid_s[0])
        self.look()

    def look(self) -> Array:
        """Update hall, draft and wobble; return the boundary temperatures [degC]."""
        place = (self.time - self._begin) / self._step
        outside = self.drive.outside
        row = min(max(int(place), 0), len(outside) - 2)
        values = outside[row] + (place - row) * (outside[row + 1] - outside[row])
        self.hall, self.draft, self.wobble = float(values[0]), float(values[-2]), float(values[-1])
        return np.asarray(values[:-2])

    def mean(self, part: str) -> float:
        """Return the mean temperature of a part's unknowns [degC]."""
        return float(self.temperature[self.machine.parts[part]].mean())


class Stepper(ABC, Generic[Kept]):
    """Steps one machine; caches from run to run what depends on speed, conductances and step."""

    steps: ClassVar[tuple[tuple[float, float], ...]]
    """Pairs of time after a switch, and step until then [s]."""
    scale_step: ClassVar[float]
    """Factors on conductances are rounded to this [1]."""
    most_kept: ClassVar[int]

    def __init__(self, machine: Any, effects: Sequence[Hidden] = (), refine: int = 1) -> None:
        self.machine, self.effects, self._refine = machine, list(effects), refine
        self._kept: OrderedDict[tuple[object, ...], Kept] = OrderedDict()
        self._capacity = machine.capacity

    @abstractmethod
    def factors(self, speed: float, step: float, scales: dict[str, float]) -> Kept:
        """Return what is constant for given speed, conductances and step."""

    @abstractmethod
    def step(self, now: Now, step: float) -> None:
        """Advance by a step [s]."""

    def run(self, drive: Drive, start: Array) -> Array:
        """Return temperatures at the rows of *drive*, shape (rows, unknowns), from *start* on."""
        now = self._begin(drive, start)
        times, states = [now.time], [now.temperature]
        for first, last in drive.segments():
            self._switch(now, first)
            for step in self._steps(float(drive.time_s[last] - drive.time_s[first])):
                self.step(now, step)
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
                self.step(now, length / count)
        return now.temperature

    def kept_at(self, now: Now, step: float) -> Kept:
        """Return the factors for now, with the conductances changed by the effects."""
        scales: dict[str, float] = {}
        for effect in self.effects:
            for group, factor in effect.scales(now).items():
                scales[group] = scales.get(group, 1.0) * factor
        rounded = {g: round(s / self.scale_step) * self.scale_step for g, s in scales.items()}
        key = (now.speed, round(step, 6), tuple(sorted(rounded.items())))
        if key in self._kept:
            self._kept.move_to_end(key)
        else:
            self._kept[key] = self.factors(now.speed, step, rounded)
            if len(self._kept) > self.most_kept:
                self._kept.popitem(last=False)
        return self._kept[key]

    def friction(self, now: Now) -> Array:
        """Return the heat of all bearings [W], as changed by the effects."""
        viscous, load = self._friction
        for effect in self.effects:
            viscous, load = effect.friction(now, viscous, load)
        wobble = now.drive.friction_factor * (1.0 + now.wobble)
        return np.asarray(self.machine.bearing_entry @ (wobble * (viscous + load)))

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
        for until, step in self.steps:
            step /= self._refine
            while done < min(until, length) - 1e-6:
                steps.append(min(step, length - done))
                done += steps[-1]
        return steps


def _interpolated(times: Array, states: Array, wanted: Array) -> Array:
    right = np.clip(np.searchsorted(times, wanted), 1, len(times) - 1)
    left = right - 1
    share = (wanted - times[left]) / (times[right] - times[left])
    return np.asarray(states[left] + share[:, None] * (states[right] - states[left]))
