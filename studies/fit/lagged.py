"""Temperatures and speed after first-order lags, the regressors of models with a memory."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fmu_compensator.fit.error_models.base import Task
from fmu_compensator.fit.training import Array, TrainingRun
from measurement.resampling import SLOW_S
from studies.fit.by_run import Block
from studies.runtime.thermal_states import SPEED_UNIT

START_MARGIN, SMALLEST_START_MARGIN_K = 0.5, 2.0
"""Widening of the range of levels at the start: share of the range [1] and minimum [K]: set on no
data."""


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
        If false, the columns of the speed and of its square are zero.
    uses_levels : bool
        If false, the columns of the temperatures above their median are zero.

    Returns
    -------
    array, shape (n, k + lags * (2 k + 2))
        The rises [K]; then, for each lag, lagged rises, levels, speed [1000 r/min] and its square.
    """
    rises = run.inputs - run.inputs[0]
    speed = run.held_speed / SPEED_UNIT
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
        Widened on either side by half the range, but at least 2 K [K].
    """
    levels = np.concatenate([_levels(run.inputs[:1]) for run in runs])
    low, high = levels.min(axis=0), levels.max(axis=0)
    margin = np.maximum(START_MARGIN * (high - low), SMALLEST_START_MARGIN_K)
    return low - margin, np.median(levels, axis=0), high + margin


def lagged(drives: Array, elapsed_s: Array, tau_s: float | Array) -> Array:
    """Return each column after a first-order lag that starts at zero, shape of *drives*.

    Parameters
    ----------
    drives : array, shape (n, columns)
        Inputs of the lag, in any unit.
    elapsed_s : array, shape (n,)
        Time since the previous row; 0 for the first [s].
    tau_s : float or array, shape (n,)
        Time constant, or one for the step to each row [s].
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
        Minimum time between two rows [s].

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


def needed(run: TrainingRun, step_s: float) -> NDArray[np.bool_]:
    """Return whether a model whose steps are exact at constant speed needs each row, shape (n,).

    It needs the rows of `thinned`, every change of speed, and the ends.

    Parameters
    ----------
    run : TrainingRun
    step_s : float
        Minimum time between two rows with targets [s].
    """
    rows = np.zeros(len(run.time_s), dtype=bool)
    rows[[0, -1]] = True
    rows[thinned(run, step_s)] = True
    speed = run.speed
    rows[1:] |= ~((speed[1:] == speed[:-1]) | np.isnan(speed[1:]))
    return rows


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
        As for `features`.
    """
    return [
        Block(
            (run.time_s[row := thinned(run, SLOW_S)] - run.time_s[0]) / 3600.0,
            features(run, lags_s, uses_speed=uses_speed, uses_levels=uses_levels)[row],
            run.targets[row],
        )
        for run in learnt_from(task)
    ]


def learnt_from(task: Task) -> list[TrainingRun]:
    """Return the runs with at least two thinned rows, which form blocks."""
    return [run for run in task.runs if len(thinned(run, SLOW_S)) > 1]
