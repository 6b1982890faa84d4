"""What a run does to the machine: speed, torque, hall, coolant, and disturbances nobody records."""

from __future__ import annotations

import numpy as np

from benchmarks.gap.drive import Array, Stretches, Tests, air_of, until, wander


def _outside(rng: np.random.Generator, grid: Array, hall: dict[str, float]) -> Array:
    """Return air, air at column and bed, inlet, draft and wobble."""
    ranges = ((6.0, 10.0), (0.6, 1.3), (-1.5, 1.5))
    air = air_of(rng, grid, hall, ranges, ((0.15, 5400.0), (0.05, 600.0)))
    above = 0.3 + wander(rng, grid, 0.1, 7200.0)
    inlet = hall["coolant"] + 0.35 * (air - hall["mean"]) + wander(rng, grid, 0.08, 2400.0)
    inlet = (
        inlet
        + float(rng.uniform(-0.3, 0.3))
        + float(rng.uniform(0.0, 0.8))
        * np.clip(1.0 - np.exp(-np.maximum(grid, 0.0) / 5000.0), 0.0, 1.0)
    )
    draft = np.clip(wander(rng, grid, 0.06, 1500.0), -0.2, 0.2)
    wobble = wander(rng, grid, 0.006, 2700.0)
    return np.column_stack([air, air + above, inlet, draft, wobble])


def _stretches(family: str, rng: np.random.Generator, _: float, last: float) -> Stretches:
    found = _FAMILIES[family](rng, last)
    if rng.random() < 0.5:
        found = [(float(rng.uniform(300.0, 900.0)), 0.0, 0.0, 0.0), *found]
    # A brake of 12 kW loads the spindle.
    most = [12e3 / max(n * np.pi / 30.0, 1.0) for _, n, _, _ in found]
    return [
        (length, round(n, -2), 0.0, round(min(load, limit, 12.0), 1) if n > 0.0 else 0.0)
        for (length, n, _, load), limit in zip(found, most, strict=True)
    ]


def _steps(rng: np.random.Generator, last: float) -> Stretches:
    top = float(rng.uniform(15e3, 20e3))
    count = int(rng.integers(4, 7))
    rising = np.linspace(top / count, top, count)
    order = [*rising, *rising[-2::-2]] if rng.random() < 0.5 else [*rising[::-1], *rising[1::2]]
    return [(0.88 * last / len(order), float(n), 0.0, 0.0) for n in order]


def _random(rng: np.random.Generator, last: float) -> Stretches:
    def draw() -> Stretches:
        n = 0.0 if rng.random() < 0.15 else float(rng.uniform(1500.0, 20e3))
        load = float(rng.uniform(2.0, 8.0)) if rng.random() < 0.4 else 0.0
        return [(float(rng.uniform(600.0, 2700.0)), n, 0.0, load)]

    return until(0.9 * last, draw)


def _stop_and_go(rng: np.random.Generator, last: float) -> Stretches:
    n = float(rng.uniform(9e3, 18e3))

    def draw() -> Stretches:
        load = float(rng.uniform(2.0, 8.0)) if rng.random() < 0.5 else 0.0
        return [
            (float(rng.uniform(900.0, 2400.0)), n * float(rng.uniform(0.7, 1.1)), 0.0, load),
            (float(rng.uniform(300.0, 1500.0)), 0.0, 0.0, 0.0),
        ]

    return until(0.9 * last, draw)


def _iso(rng: np.random.Generator, last: float) -> Stretches:
    """Four hours at one speed, one at rest, then what time is left at another."""
    n = float(rng.uniform(8e3, 18e3))
    on = min(4.0 * 3600.0, 0.7 * last)
    other = float(rng.uniform(4e3, 16e3))
    return [(on, n, 0.0, 0.0), (3600.0, 0.0, 0.0, 0.0), (last, other, 0.0, 0.0)]


def _ramp_down(rng: np.random.Generator, last: float) -> Stretches:
    top, count = float(rng.uniform(16e3, 20e3)), int(rng.integers(5, 9))
    return [(0.85 * last / count, float(n), 0.0, 0.0) for n in np.linspace(top, 2e3, count)]


def _blocks(rng: np.random.Generator, last: float) -> Stretches:
    """Two jobs that take turns, with a break between and torque in one of them."""
    slow, fast = float(rng.uniform(3e3, 7e3)), float(rng.uniform(12e3, 20e3))

    def draw() -> Stretches:
        return [
            (float(rng.uniform(1800.0, 4200.0)), fast, 0.0, 0.0),
            (float(rng.uniform(1800.0, 3600.0)), slow, 0.0, float(rng.uniform(3.0, 10.0))),
            (float(rng.uniform(300.0, 1200.0)), 0.0, 0.0, 0.0),
        ]

    return until(0.85 * last, draw)


_FAMILIES = {
    "steps": _steps,
    "random": _random,
    "stop_and_go": _stop_and_go,
    "iso": _iso,
    "ramp_down": _ramp_down,
    "blocks": _blocks,
}

TESTS = Tests(
    families=tuple(_FAMILIES),
    often=("random", "stop_and_go", "blocks"),
    stretches=_stretches,
    outside=_outside,
    unsteady=(0.007, 0.005),
    jitter=0.04,
)
"""Torque occurs in those that are often."""
