"""What a run does to the machine: speed, torque, hall, coolant, and disturbances nobody records."""

from __future__ import annotations

import numpy as np

from benchmarks.gap.drive import GRID, Array, Drive, wander

FAMILIES = ("steps", "random", "stop_and_go", "iso", "ramp_down", "blocks")


def make_drive(
    family: str, rng: np.random.Generator, period: float, hall: dict[str, float], before: float
) -> Drive:
    """Return a run of a family of speed spectra.

    Parameters
    ----------
    period : float
        Sampling interval [s].
    hall : dict
        Of this machine: mean [degC], daily swing [K], coolant set point [degC].
    before : float
        Hours of past that the outside must cover.
    """
    duration = float(rng.uniform(5.0, 8.0)) * 3600.0
    rows = int(duration // period) + 1
    nominal = period * np.arange(rows)
    speed, torque = _spectrum(family, rng, nominal)
    jitter = rng.uniform(-0.04, 0.04, rows) * period
    changes = np.flatnonzero((np.diff(speed) != 0.0) | (np.diff(torque) != 0.0)) + 1
    jitter[[0, -1]] = 0.0
    jitter[changes] = 0.0  # a change of speed is recorded when it happens
    grid = np.arange(-before * 3600.0, nominal[-1] + 2.0 * GRID, GRID)
    return Drive(
        family,
        np.round(nominal + jitter, 2),
        speed,
        np.zeros(rows),
        torque,
        grid,
        _outside(rng, grid, hall),
        friction_factor=1.0 + 0.007 * float(rng.standard_normal()),
        drive_factor=1.0 + 0.005 * float(rng.standard_normal()),
    )


def _outside(rng: np.random.Generator, grid: Array, hall: dict[str, float]) -> Array:
    hour = grid / 3600.0
    phase = float(rng.uniform(6.0, 10.0))
    swing = hall["swing"] * float(rng.uniform(0.6, 1.3))
    air = hall["mean"] + float(rng.uniform(-1.5, 1.5))
    air = air - swing * np.cos(2.0 * np.pi * (hour + phase) / 24.0)
    air = air + wander(rng, grid, 0.15, 5400.0) + wander(rng, grid, 0.05, 600.0)
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


def _spectrum(family: str, rng: np.random.Generator, time_s: Array) -> tuple[Array, Array]:
    stretches = _STRETCHES[family](rng, float(time_s[-1]))
    if rng.random() < 0.5:
        stretches = [(float(rng.uniform(300.0, 900.0)), 0.0, 0.0), *stretches]
    speed, torque = np.zeros(len(time_s)), np.zeros(len(time_s))
    begin = 0.0
    for length, n, load in stretches:
        rows = time_s >= begin - 1e-9
        speed[rows] = round(n, -2)
        # A brake of 12 kW loads the spindle.
        most = 12e3 / max(n * np.pi / 30.0, 1.0)
        torque[rows] = round(min(load, most, 12.0), 1) if n > 0.0 else 0.0
        begin += length
        if begin >= time_s[-1]:
            break
    torque[speed == 0.0] = 0.0
    return speed, torque


Stretches = list[tuple[float, float, float]]


def _steps(rng: np.random.Generator, duration: float) -> Stretches:
    top = float(rng.uniform(15e3, 20e3))
    count = int(rng.integers(4, 7))
    rising = np.linspace(top / count, top, count)
    order = [*rising, *rising[-2::-2]] if rng.random() < 0.5 else [*rising[::-1], *rising[1::2]]
    length = 0.88 * duration / len(order)
    return [*((length, float(n), 0.0) for n in order), (duration, 0.0, 0.0)]


def _random(rng: np.random.Generator, duration: float) -> Stretches:
    found: Stretches = []
    while sum(one[0] for one in found) < 0.9 * duration:
        n = 0.0 if rng.random() < 0.15 else float(rng.uniform(1500.0, 20e3))
        load = float(rng.uniform(2.0, 8.0)) if rng.random() < 0.4 else 0.0
        found.append((float(rng.uniform(600.0, 2700.0)), n, load))
    return [*found, (duration, 0.0, 0.0)]


def _stop_and_go(rng: np.random.Generator, duration: float) -> Stretches:
    n = float(rng.uniform(9e3, 18e3))
    found: Stretches = []
    while sum(one[0] for one in found) < 0.9 * duration:
        load = float(rng.uniform(2.0, 8.0)) if rng.random() < 0.5 else 0.0
        found.append((float(rng.uniform(900.0, 2400.0)), n * float(rng.uniform(0.7, 1.1)), load))
        found.append((float(rng.uniform(300.0, 1500.0)), 0.0, 0.0))
    return [*found, (duration, 0.0, 0.0)]


def _iso(rng: np.random.Generator, duration: float) -> Stretches:
    """Four hours at one speed, one at rest, then what time is left at another."""
    n = float(rng.uniform(8e3, 18e3))
    on = min(4.0 * 3600.0, 0.7 * duration)
    return [(on, n, 0.0), (3600.0, 0.0, 0.0), (duration, float(rng.uniform(4e3, 16e3)), 0.0)]


def _ramp_down(rng: np.random.Generator, duration: float) -> Stretches:
    top, count = float(rng.uniform(16e3, 20e3)), int(rng.integers(5, 9))
    length = 0.85 * duration / count
    speeds = np.linspace(top, 2e3, count)
    return [*((length, float(n), 0.0) for n in speeds), (duration, 0.0, 0.0)]


def _blocks(rng: np.random.Generator, duration: float) -> Stretches:
    """Two jobs that take turns, with a break between and torque in one of them."""
    slow, fast = float(rng.uniform(3e3, 7e3)), float(rng.uniform(12e3, 20e3))
    found: Stretches = []
    while sum(one[0] for one in found) < 0.85 * duration:
        found.append((float(rng.uniform(1800.0, 4200.0)), fast, 0.0))
        found.append((float(rng.uniform(1800.0, 3600.0)), slow, float(rng.uniform(3.0, 10.0))))
        found.append((float(rng.uniform(300.0, 1200.0)), 0.0, 0.0))
    return [*found, (duration, 0.0, 0.0)]


_STRETCHES = {
    "steps": _steps,
    "random": _random,
    "stop_and_go": _stop_and_go,
    "iso": _iso,
    "ramp_down": _ramp_down,
    "blocks": _blocks,
}
