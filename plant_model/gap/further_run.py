"""Which further run would tell two explanations apart: simulated with both, the best one told."""

from __future__ import annotations

import numpy as np
import pandas as pd

from plant_model.gap.observations import Observations
from plant_model.gap.regimes import noise_of
from plant_model.machine import Machine
from plant_model.parameters import FloatArray
from plant_model.sensors import displacement_names
from plant_model.simulate import simulate

HOURS = 6.0

PROFILES: dict[str, list[tuple[float, float]]] = {
    "6 h at the highest speed": [(0.0, 1.0)],
    "3 h at the highest speed, then standing for 3 h": [(0.0, 1.0), (3.0, 0.0)],
    "3 h at a third of the highest speed, then 3 h at the highest": [(0.0, 0.33), (3.0, 1.0)],
    "half an hour on and half an hour off at the highest speed": [
        (0.5 * i, 1.0 - i % 2) for i in range(12)
    ],
    "speeds rising by a sixth of the highest every hour": [
        (float(i), (i + 1) / 6.0) for i in range(6)
    ],
    "6 h at a quarter of the highest speed": [(0.0, 0.25)],
}
"""Runs to choose from: hours at which the share of the highest speed seen so far changes."""


def further_run(first: Machine, second: Machine, observed: list[Observations]) -> str:
    """Return the run that tells two machines apart best, and what would differ, as a sentence."""
    names = observed[0].channels
    noise = noise_of(first, names)
    best = ("", "", 0.0, 0.0)
    for profile, changes in PROFILES.items():
        inputs = _inputs(first, changes, observed)
        apart = [_channels(machine, inputs, names) for machine in (first, second)]
        difference = np.max(np.abs(apart[0] - apart[1]), axis=0)
        i = int(np.argmax(difference / noise))
        if difference[i] / noise[i] > best[2]:
            best = (profile, names[i], float(difference[i] / noise[i]), float(difference[i]))
    profile, channel, times, size = best
    if times < 2.0:
        return "no run of those tried: the two differ by less than twice the sensors' noise in all"
    unit = "um" if channel in displacement_names(first) else "K"
    return f"{profile}: {channel} would differ by up to {size:.2g} {unit}"


def _inputs(
    machine: Machine, changes: list[tuple[float, float]], observed: list[Observations]
) -> pd.DataFrame:
    time = np.arange(0.0, HOURS * 3600.0 + 30.0, 60.0)
    frames = [one.run.frame for one in observed]
    columns = {"time_s": time}
    at = np.searchsorted([hour * 3600.0 for hour, _ in changes], time, side="right") - 1
    share = np.array([value for _, value in changes])[at]
    for entry in machine.inputs:
        seen = [frame[entry.column] for frame in frames if entry.column in frame]
        if not seen:
            continue
        if entry.is_boundary:
            columns[entry.name] = np.full(len(time), float(np.nanmean(np.concatenate(seen))))
        elif entry.default is None:
            columns[entry.name] = share * max(float(np.nanmax(part)) for part in seen)
    return pd.DataFrame(columns)


def _channels(machine: Machine, inputs: pd.DataFrame, names: tuple[str, ...]) -> FloatArray:
    shown = simulate(machine, inputs, step_s=60.0, tolerance=1e-2).readings
    return np.stack([shown[name][0] for name in names], axis=-1)
