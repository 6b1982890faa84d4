"""The inputs of a run, for any simulator: commands, surroundings and their random variation."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

GRID = 20.0  # s
REST = "rest"
"""The family of the standstill before a run."""


@dataclass(frozen=True)
class Drive:
    """All inputs of one run.

    Attributes
    ----------
    family : str
        Kind of test.
    time_s, speed, feed, torque : array, shape (rows,)
        Recording instants [s]; values from each instant on [r/min, mm/min, Nm].
    grid_s : array
        Even grid of `outside` [s]; begins before the run if it has a past.
    outside : array, shape (grid, 2 + boundaries)
        Boundary temperatures [degC], the hall or the air first; then relative draft and relative
        wobble of friction.
    friction_factor, drive_factor : float
        Factors on the usual losses of bearings, and of motor or belt, in this run [1].
    """

    family: str
    time_s: Array
    speed: Array
    feed: Array
    torque: Array
    grid_s: Array
    outside: Array
    friction_factor: float = 1.0
    drive_factor: float = 1.0

    def segments(self) -> list[tuple[int, int]]:
        """Return the first and last row of every stretch without a switch."""
        driven = np.stack([self.speed, self.feed, self.torque])
        change = np.flatnonzero(np.any(np.diff(driven) != 0.0, axis=0)) + 1
        edges = [0, *change.tolist(), len(self.time_s) - 1]
        return [(a, b) for a, b in pairwise(edges) if b > a]

    def at(self, which: int = 0) -> Array:
        """Return a column of `outside` at the rows."""
        return np.asarray(np.interp(self.time_s, self.grid_s, self.outside[:, which]))

    def rest(self, hours: float) -> Drive:
        """Return the standstill before the run, up to the run's first row."""
        end, zero = float(self.time_s[0]), np.zeros(2)
        time_s = np.array([end - 3600.0 * hours, end])
        return Drive(REST, time_s, zero, zero, zero, self.grid_s, self.outside)


Stretches = list[tuple[float, float, float, float]]
"""Length [s], speed [r/min], feed [mm/min], torque [Nm]."""


@dataclass(frozen=True)
class Tests:
    """The tests that are run on the machines of a simulator.

    Attributes
    ----------
    families : tuple of str
        Kinds of test, each of which a case has at most once.
    often : tuple of str
        Three of them, of which two are among a case's first four runs, and the other is the last.
    stretches : callable
        Returns those of a run from its family, a stream, its duration and its last instant [s]. If
        they end before, the machine rests.
    outside : callable
        Returns `Drive.outside` from a stream, its grid and the hall's properties.
    unsteady : (float, float)
        Standard deviations of `Drive.friction_factor` and `Drive.drive_factor` [1].
    jitter : float
        Of recording times, as a share of the interval [1].
    """

    families: tuple[str, ...]
    often: tuple[str, str, str]
    stretches: Callable[[str, np.random.Generator, float, float], Stretches]
    outside: Callable[[np.random.Generator, Array, dict[str, float]], Array]
    unsteady: tuple[float, float]
    jitter: float = 0.0

    def plan(self, rng: np.random.Generator) -> list[str]:
        """Return one family for each of five runs."""
        often = list(self.often)
        others = [name for name in self.families if name not in often]
        rng.shuffle(often)
        rng.shuffle(others)
        calibration = [*often[:2], *others[:2]]
        rng.shuffle(calibration)
        return [*calibration, often[2]]

    def drive(
        self,
        family: str,
        rng: np.random.Generator,
        period: float,
        hall: dict[str, float],
        before: float,
    ) -> Drive:
        """Return a run of a family.

        Parameters
        ----------
        family : str
        rng : Generator
        period : float
            Sampling interval [s].
        hall : dict
            Properties of this machine's hall.
        before : float
            Hours of past that the outside must cover.
        """
        duration = float(rng.uniform(5.0, 8.0)) * 3600.0
        time_s = period * np.arange(int(duration // period) + 1)
        stretches = self.stretches(family, rng, duration, float(time_s[-1]))
        driven, begin = np.zeros((3, len(time_s))), 0.0
        for length, *values in [*stretches, (duration, 0.0, 0.0, 0.0)]:
            driven[:, time_s >= begin - 1e-9] = np.array(values)[:, None]
            begin += length
        grid = np.arange(-before * 3600.0, time_s[-1] + 2.0 * GRID, GRID)
        if self.jitter:
            jitter = rng.uniform(-self.jitter, self.jitter, len(time_s)) * period
            # A change of speed is recorded when it happens.
            changes = np.flatnonzero(np.any(np.diff(driven) != 0.0, axis=0)) + 1
            jitter[[0, -1, *changes]] = 0.0
            time_s = np.round(time_s + jitter, 2)
        outside = self.outside(rng, grid, hall)
        friction, drive = (1.0 + size * float(rng.standard_normal()) for size in self.unsteady)
        speed, feed, torque = driven
        return Drive(family, time_s, speed, feed, torque, grid, outside, friction, drive)


def until(end: float, draw: Callable[[], Stretches]) -> Stretches:
    """Return drawn stretches that together last until *end* [s] or longer."""
    found: Stretches = []
    while sum(one[0] for one in found) < end:
        found += draw()
    return found


def air_of(
    rng: np.random.Generator,
    grid: Array,
    hall: dict[str, float],
    ranges: tuple[tuple[float, float], tuple[float, float], tuple[float, float]],
    wandering: tuple[tuple[float, float], tuple[float, float]],
) -> Array:
    """Return a hall's air: its mean, its day, and what wanders.

    Parameters
    ----------
    ranges : tuple of (float, float)
        Of the day's phase [h], of this day's swing over the usual [1], of its mean over the usual
        [K].
    wandering : tuple of (float, float)
        Size [K] and time constant [s].
    """
    phase, swing, mean = (float(rng.uniform(*ends)) for ends in ranges)
    day = np.cos(2.0 * np.pi * (grid / 3600.0 + phase) / 24.0)
    air = hall["mean"] + mean - hall["swing"] * swing * day
    for size, tau in wandering:
        air = air + wander(rng, grid, size, tau)
    return np.asarray(air)


def wander(rng: np.random.Generator, grid: Array, size: float, tau: float) -> Array:
    """Return an Ornstein-Uhlenbeck path of standard deviation *size*, smoothed over a tenth."""
    decay = np.exp(-GRID / tau)
    kick = size * np.sqrt(1.0 - decay**2) * rng.standard_normal(len(grid))
    path = np.empty(len(grid))
    state = size * float(rng.standard_normal())
    for k, push in enumerate(kick.tolist()):
        state = decay * state + push
        path[k] = state
    width = max(1, int(0.1 * tau / GRID))
    padded = np.concatenate([np.full(width, path[0]), path, np.full(width, path[-1])])
    smooth = np.convolve(padded, np.ones(width) / width, "same")
    return np.asarray(smooth[width:-width])


def lagged(time_s: Array, values: Array, tau_s: float) -> Array:
    """Return a first-order lag of *values*, initially in equilibrium, exact for linear segments."""
    out = np.empty_like(values)
    out[0] = state = float(values[0])
    for k in range(1, len(values)):
        h = float(time_s[k] - time_s[k - 1])
        decay = np.exp(-h / tau_s)
        slope = float(values[k] - values[k - 1]) / h
        # Response to a ramp: the lag follows it tau behind.
        ahead = float(values[k]) - slope * tau_s
        state = ahead + decay * (state - (float(values[k - 1]) - slope * tau_s))
        out[k] = state
    return out
