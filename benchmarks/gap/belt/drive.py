"""What a run does to the machine: speed, feed, torque, hall, and disturbances nobody records."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from benchmarks.gap.belt.machine import TOP_SPEED
from benchmarks.gap.drive import GRID, Array, Drive, wander

TOP_FEED = 10000.0


def make_drive(
    family: str,
    rng: np.random.Generator,
    period: float,
    hall: dict[str, float],
    before: float,
    *,
    slower: float = 1.0,
) -> Drive:
    """Return a run of a family.

    Parameters
    ----------
    family : str
    rng : Generator
    period : float
        Sampling interval [s].
    hall : dict
        Of this machine's hall: mean [degC], daily swing [K].
    before : float
        Hours of past that the outside must cover.
    slower : float
        Speeds are this share of those of the belt-driven spindle.
    """
    duration = float(rng.uniform(5.0, 8.0)) * 3600.0
    rows = int(duration // period) + 1
    time_s = period * np.arange(rows)
    speed, feed, torque = np.zeros(rows), np.zeros(rows), np.zeros(rows)
    begin = float(rng.uniform(300.0, 900.0)) if rng.random() < 0.6 else 0.0
    for length, n, moved, load in FAMILIES[family](rng, duration):
        later = time_s >= begin - 1e-9
        speed[later], feed[later] = round(slower * n, -2), round(moved, -2)
        torque[later] = round(load, 1) if n > 0.0 else 0.0
        begin += length
    grid = np.arange(-before * 3600.0, time_s[-1] + 2.0 * GRID, GRID)
    return Drive(
        family,
        time_s,
        speed,
        feed,
        torque,
        grid,
        _outside(rng, grid, hall),
        friction_factor=1.0 + 0.008 * float(rng.standard_normal()),
        drive_factor=1.0 + 0.01 * float(rng.standard_normal()),
    )


def _outside(rng: np.random.Generator, grid: Array, hall: dict[str, float]) -> Array:
    hour = grid / 3600.0
    phase, swing = float(rng.uniform(5.0, 11.0)), hall["swing"] * float(rng.uniform(0.5, 1.4))
    air = hall["mean"] + float(rng.uniform(-2.0, 2.0))
    air = air - swing * np.cos(2.0 * np.pi * (hour + phase) / 24.0)
    air = air + wander(rng, grid, 0.2, 4800.0) + wander(rng, grid, 0.04, 600.0)
    draft = np.clip(wander(rng, grid, 0.05, 1800.0), -0.2, 0.2)
    return np.column_stack([air, draft, wander(rng, grid, 0.006, 2400.0)])


Stretches = list[tuple[float, float, float, float]]
"""Length [s], speed [r/min], feed [mm/min], torque [Nm]."""


def _staircase(rng: np.random.Generator, duration: float) -> Stretches:
    top, count = float(rng.uniform(0.75, 1.0)) * TOP_SPEED, int(rng.integers(3, 6))
    speeds = np.linspace(top / count, top, count)
    order = speeds if rng.random() < 0.5 else speeds[::-1]
    length = 0.8 * duration / count
    return [*((length, float(n), 0.0, 0.0) for n in order), (duration, 0.0, 0.0, 0.0)]


def _one_speed(rng: np.random.Generator, duration: float) -> Stretches:
    """Four hours at one speed, then at rest: the test of ISO 230-3."""
    n = float(rng.uniform(0.5, 1.0)) * TOP_SPEED
    return [(0.6 * duration, n, 0.0, 0.0), (duration, 0.0, 0.0, 0.0)]


def _axis_only(rng: np.random.Generator, duration: float) -> Stretches:
    """The axis goes up and down at several feeds, then the spindle turns."""
    feeds = rng.uniform(0.3, 1.0, 2) * TOP_FEED
    n = float(rng.uniform(0.4, 0.9)) * TOP_SPEED
    return [
        (0.25 * duration, 0.0, float(feeds[0]), 0.0),
        (0.15 * duration, 0.0, 0.0, 0.0),
        (0.25 * duration, n, float(feeds[1]), 0.0),
        (0.15 * duration, n, 0.0, 0.0),
        (duration, 0.0, 0.0, 0.0),
    ]


def _shifts(rng: np.random.Generator, duration: float) -> Stretches:
    """Jobs with cutting and moving, breaks between them."""
    found: Stretches = []
    while sum(one[0] for one in found) < 0.9 * duration:
        n = float(rng.uniform(0.25, 1.0)) * TOP_SPEED
        moved = float(rng.uniform(0.1, 0.8)) * TOP_FEED
        load = min(float(rng.uniform(3.0, 20.0)), 9e3 / (n * np.pi / 30.0))
        found.append((float(rng.uniform(1200.0, 4200.0)), n, moved, load))
        found.append((float(rng.uniform(300.0, 1500.0)), 0.0, 0.0, 0.0))
    return [*found, (duration, 0.0, 0.0, 0.0)]


def _random(rng: np.random.Generator, duration: float) -> Stretches:
    found: Stretches = []
    while sum(one[0] for one in found) < 0.92 * duration:
        n = 0.0 if rng.random() < 0.2 else float(rng.uniform(0.1, 1.0)) * TOP_SPEED
        moved = float(rng.uniform(0.1, 1.0)) * TOP_FEED if rng.random() < 0.4 else 0.0
        load = float(rng.uniform(2.0, 9.0)) if n and rng.random() < 0.3 else 0.0
        found.append((float(rng.uniform(600.0, 3000.0)), n, moved, load))
    return [*found, (duration, 0.0, 0.0, 0.0)]


def _alternating(rng: np.random.Generator, duration: float) -> Stretches:
    slow, fast = rng.uniform(0.15, 0.4) * TOP_SPEED, rng.uniform(0.7, 1.0) * TOP_SPEED
    length, moved = float(rng.uniform(1500.0, 3600.0)), float(rng.uniform(0.2, 0.6)) * TOP_FEED
    found: Stretches = []
    while sum(one[0] for one in found) < 0.85 * duration:
        found += [(length, float(fast), 0.0, 0.0), (length, float(slow), moved, 0.0)]
    return [*found, (duration, 0.0, 0.0, 0.0)]


FAMILIES: dict[str, Callable[[np.random.Generator, float], Stretches]] = {
    "staircase": _staircase,
    "one_speed": _one_speed,
    "axis_only": _axis_only,
    "shifts": _shifts,
    "random": _random,
    "alternating": _alternating,
}
"""Kinds of test, each of which a case has at most once."""

MOVING = ("axis_only", "shifts", "random")
"""Those in which the axis moves for long: two of them are among a case's first four runs."""


def families(rng: np.random.Generator) -> list[str]:
    """Return one family for each run; the axis moves in two of the first four."""
    moving = list(MOVING)
    still = [name for name in FAMILIES if name not in moving]
    rng.shuffle(moving)
    rng.shuffle(still)
    calibration = [*moving[:2], *still[:2]]
    rng.shuffle(calibration)
    return [*calibration, moving[2]]
