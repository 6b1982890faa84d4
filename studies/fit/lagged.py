"""Temperatures and speed behind first-order lags: what regressions with a memory take in."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import pandas as pd

from fmu_compensator.fit.error_models.base import Task
from fmu_compensator.fit.training import Array, TrainingRun
from studies.fit.by_run import Block
from studies.runtime.thermal_states import SPEED_UNIT

THIN_S = 300.0
"""Rows closer together say the same; they are thinned to this for fitting [s]: set on no
data."""
START_MARGIN, SMALLEST_START_MARGIN_K = 0.5, 2.0
"""By how much the range of levels at the start is widened: share of it [1], at least [K]: set on
no data."""


def features(
    run: TrainingRun,
    lags_s: Sequence[float],
    *,
    uses_speed: bool,
    uses_levels: bool,
) -> Array:
    """Return the regressors of every row.

    Parameters
    ----------
    run : TrainingRun
        With k inputs [degC or K], in n rows.
    lags_s : sequence of float
        Time constants of the lags [s].
    uses_speed : bool
        If not, the columns of the speed and of its square hold zeros.
    uses_levels : bool
        If not, the columns of what each temperature is above their median hold zeros.

    Returns
    -------
    array, shape (n, k + lags * (2 k + 2))
        The rises [K]; then for each lag rises, levels, speed [1000 r/min] and its square,
        lagged.
    """
    rises = run.inputs - run.inputs[0]
    speed = held_speed(run) / SPEED_UNIT
    drives = np.column_stack([rises, _levels(run.inputs), speed, speed**2])
    if not uses_speed:
        drives[:, -2:] = 0.0
    if not uses_levels:
        drives[:, rises.shape[1] : -2] = 0.0
    elapsed = np.diff(run.time_s, prepend=run.time_s[0])
    return np.column_stack([rises, *(lagged(drives, elapsed, lag) for lag in lags_s)])


def _levels(inputs: Array) -> Array:
    return np.asarray(inputs - np.median(inputs, axis=1, keepdims=True))


def start_range(runs: Sequence[TrainingRun]) -> tuple[Array, Array, Array]:
    """Return the range of levels at the start over all runs, widened, and their middle [K].

    Parameters
    ----------
    runs : sequence of TrainingRun
        All with the same k inputs.

    Returns
    -------
    low, middle, high : array, shape (k,)
        Widened by half the range on either side, by 2 K at least [K].
    """
    levels = np.concatenate([_levels(run.inputs[:1]) for run in runs])
    low, high = levels.min(axis=0), levels.max(axis=0)
    margin = np.maximum(START_MARGIN * (high - low), SMALLEST_START_MARGIN_K)
    return low - margin, np.median(levels, axis=0), high + margin


def held_speed(run: TrainingRun) -> Array:
    """Return the speed that held until each row: that of the row before, the last one known.

    Parameters
    ----------
    run : TrainingRun
        Its speeds may be of either sign, or missing.

    Returns
    -------
    array, shape (n,)
        0 before the first that is known [rpm].
    """
    speeds = pd.Series(np.where(np.isfinite(run.speed), np.abs(run.speed), np.nan))
    return np.asarray(speeds.shift().ffill().fillna(0.0), dtype=np.float64)


def lagged(drives: Array, elapsed_s: Array, tau_s: float | Array) -> Array:
    """Return each column behind a first-order lag that starts at zero, shape of *drives*.

    Parameters
    ----------
    drives : array, shape (n, columns)
        What the lag follows, in any unit.
    elapsed_s : array, shape (n,)
        Time since the row before; 0 for the first [s].
    tau_s : float or array, shape (n,)
        Time constant, or that of the step to each row [s].
    """
    shares = -np.expm1(-elapsed_s / tau_s)
    values = np.zeros_like(drives)
    value = np.zeros(drives.shape[1])
    for k, (drive, part) in enumerate(zip(drives, shares, strict=True)):
        value = value + part * (drive - value)
        values[k] = value
    return values


def thinned(run: TrainingRun, step_s: float) -> np.ndarray[Any, np.dtype[np.intp]]:
    """Return the rows with targets, no two closer than *step_s*.

    Parameters
    ----------
    run : TrainingRun
    step_s : float
        Least time between two rows that are kept [s].

    Returns
    -------
    array of int, shape (rows kept,)
        Their positions in the run.
    """
    kept: list[int] = []
    for row in np.flatnonzero(run.known):
        if not kept or run.time_s[row] - run.time_s[kept[-1]] >= step_s:
            kept.append(int(row))
    return np.array(kept, dtype=np.intp)


def blocks_of(
    task: Task, lags_s: Sequence[float], *, uses_speed: bool, uses_levels: bool
) -> list[Block]:
    """Return the thinned rows of the runs of `learnt_from` as regressors and targets.

    Parameters
    ----------
    task : Task
    lags_s : sequence of float
        Time constants [s].
    uses_speed, uses_levels : bool
        As `features` takes them.
    """
    return [
        Block(
            (run.time_s[row := thinned(run, THIN_S)] - run.time_s[0]) / 3600.0,
            features(run, lags_s, uses_speed=uses_speed, uses_levels=uses_levels)[row],
            run.targets[row],
        )
        for run in learnt_from(task)
    ]


def learnt_from(task: Task) -> list[TrainingRun]:
    """Return the runs that make a block: those with two thinned rows or more."""
    return [run for run in task.runs if len(thinned(run, THIN_S)) > 1]
