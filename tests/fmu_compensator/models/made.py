"""Training runs with known answers."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from fmu_compensator.fit.error_models.base import Task
from fmu_compensator.fit.training import TrainingRun, row_weights


def run_of(
    inputs: Any,
    targets: Any,
    *,
    speed: Any = None,
    step_s: float = 60.0,
    name: str = "run",
    time_s: Any = None,
) -> TrainingRun:
    x, y = np.asarray(inputs, float), np.asarray(targets, float)
    time = step_s * np.arange(len(x)) if time_s is None else np.asarray(time_s, float)
    v = np.full(len(x), np.nan) if speed is None else np.asarray(speed, float)
    known = np.isfinite(y).all(axis=1)
    weights = np.zeros(len(x))
    weights[known] = row_weights(time[known])
    return TrainingRun(name, time, x, y, v, weights)


def task_of(runs: Sequence[TrainingRun], form: str = "rise") -> Task:
    inputs, targets = runs[0].inputs.shape[1], runs[0].targets.shape[1]
    return Task(
        list(runs), [f"T{k + 1}" for k in range(inputs)], [f"y{k}" for k in range(targets)], form
    )


def steps(seed: int, rows: int = 300, hold: int = 30) -> Any:
    """Return a speed that jumps between levels and stops now and then [rpm]."""
    random = np.random.default_rng(seed)
    levels = random.choice([0.0, 3000.0, 6000.0, 12000.0], rows // hold + 1)
    return np.repeat(levels, hold)[:rows]


def lag(values: Any, tau_s: float, step_s: float = 60.0) -> Any:
    """Return a first-order lag of a series, its input held from the sample before."""
    share = 1.0 - np.exp(-step_s / tau_s)
    out = np.zeros(len(values))
    for k in range(1, len(values)):
        out[k] = out[k - 1] + share * (values[k - 1] - out[k - 1])
    return out


def rms(values: Any) -> float:
    """Return the root mean square of what is known."""
    return float(np.sqrt(np.nanmean(np.square(values))))
