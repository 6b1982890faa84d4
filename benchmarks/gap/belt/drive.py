"""What a run does to the machine: speed, feed, torque, hall, and disturbances nobody records."""

from __future__ import annotations

import numpy as np

from benchmarks.gap.belt.machine import TOP_SPEED
from benchmarks.gap.drive import Array, Stretches, Tests, air_of, until, wander

TOP_FEED = 10000.0


def _outside(rng: np.random.Generator, grid: Array, hall: dict[str, float]) -> Array:
    """Return hall, draft and wobble."""
    ranges = ((5.0, 11.0), (0.5, 1.4), (-2.0, 2.0))
    air = air_of(rng, grid, hall, ranges, ((0.2, 4800.0), (0.04, 600.0)))
    draft = np.clip(wander(rng, grid, 0.05, 1800.0), -0.2, 0.2)
    return np.column_stack([air, draft, wander(rng, grid, 0.006, 2400.0)])


def _staircase(rng: np.random.Generator, duration: float) -> Stretches:
    top, count = float(rng.uniform(0.75, 1.0)) * TOP_SPEED, int(rng.integers(3, 6))
    speeds = np.linspace(top / count, top, count)
    order = speeds if rng.random() < 0.5 else speeds[::-1]
    return [(0.8 * duration / count, float(n), 0.0, 0.0) for n in order]


def _one_speed(rng: np.random.Generator, duration: float) -> Stretches:
    """Four hours at one speed, then at rest: the test of ISO 230-3."""
    return [(0.6 * duration, float(rng.uniform(0.5, 1.0)) * TOP_SPEED, 0.0, 0.0)]


def _axis_only(rng: np.random.Generator, duration: float) -> Stretches:
    """The axis goes up and down at several feeds, then the spindle turns."""
    feeds = rng.uniform(0.3, 1.0, 2) * TOP_FEED
    n = float(rng.uniform(0.4, 0.9)) * TOP_SPEED
    return [
        (0.25 * duration, 0.0, float(feeds[0]), 0.0),
        (0.15 * duration, 0.0, 0.0, 0.0),
        (0.25 * duration, n, float(feeds[1]), 0.0),
        (0.15 * duration, n, 0.0, 0.0),
    ]


def _shifts(rng: np.random.Generator, duration: float) -> Stretches:
    """Jobs with cutting and moving, breaks between them."""

    def draw() -> Stretches:
        n = float(rng.uniform(0.25, 1.0)) * TOP_SPEED
        moved = float(rng.uniform(0.1, 0.8)) * TOP_FEED
        load = min(float(rng.uniform(3.0, 20.0)), 9e3 / (n * np.pi / 30.0))
        job = (float(rng.uniform(1200.0, 4200.0)), n, moved, load)
        return [job, (float(rng.uniform(300.0, 1500.0)), 0.0, 0.0, 0.0)]

    return until(0.9 * duration, draw)


def _random(rng: np.random.Generator, duration: float) -> Stretches:
    def draw() -> Stretches:
        n = 0.0 if rng.random() < 0.2 else float(rng.uniform(0.1, 1.0)) * TOP_SPEED
        moved = float(rng.uniform(0.1, 1.0)) * TOP_FEED if rng.random() < 0.4 else 0.0
        load = float(rng.uniform(2.0, 9.0)) if n and rng.random() < 0.3 else 0.0
        return [(float(rng.uniform(600.0, 3000.0)), n, moved, load)]

    return until(0.92 * duration, draw)


def _alternating(rng: np.random.Generator, duration: float) -> Stretches:
    slow, fast = rng.uniform(0.15, 0.4) * TOP_SPEED, rng.uniform(0.7, 1.0) * TOP_SPEED
    length, moved = float(rng.uniform(1500.0, 3600.0)), float(rng.uniform(0.2, 0.6)) * TOP_FEED
    both = [(length, float(fast), 0.0, 0.0), (length, float(slow), moved, 0.0)]
    return until(0.85 * duration, lambda: both)


_FAMILIES = {
    "staircase": _staircase,
    "one_speed": _one_speed,
    "axis_only": _axis_only,
    "shifts": _shifts,
    "random": _random,
    "alternating": _alternating,
}


def tests_up_to(top_speed: float) -> Tests:
    """Return the tests of a machine with another top speed [r/min]; in the frequent, axes move."""

    def stretches(family: str, rng: np.random.Generator, duration: float, _: float) -> Stretches:
        begin = float(rng.uniform(300.0, 900.0)) if rng.random() < 0.6 else 0.0
        slower = top_speed / TOP_SPEED
        return [(begin, 0.0, 0.0, 0.0)] + [
            (length, round(slower * n, -2), round(feed, -2), round(load, 1) if n > 0.0 else 0.0)
            for length, n, feed, load in _FAMILIES[family](rng, duration)
        ]

    return Tests(
        families=tuple(_FAMILIES),
        often=("axis_only", "shifts", "random"),
        stretches=stretches,
        outside=_outside,
        unsteady=(0.008, 0.01),
    )
