"""The inputs of a run, for any simulator: commands, surroundings and their random variation."""

from __future__ import annotations

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
