"""Predicts one thermometer from the others, by how it followed them at other times."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property

import numpy as np
from scipy.special import ndtri

from measurement.faults.series import valid
from measurement.resampling import FINEST_K, LAG_S, SLOW_S, WRONG
from measurement.runs import FloatArray, Run

WINDOW = int(LAG_S / SLOW_S)
"""Number of grid rows over which changes are compared."""


class Witnesses:
    """The thermometers of some runs on an even grid of times.

    Parameters
    ----------
    runs : sequence of Run
    """

    def __init__(self, runs: Sequence[Run]) -> None:
        self._runs = runs

    @cached_property
    def _grids(self) -> list[tuple[FloatArray, dict[str, FloatArray]]]:
        grids = []
        for run in self._runs:
            grid = np.arange(run.time_s[0], run.time_s[-1], SLOW_S)
            grids.append((grid, {name: _on(grid, run, name) for name in run.temperatures}))
        return grids

    @cached_property
    def _changes(self) -> list[dict[str, FloatArray]]:
        """By how much each thermometer moved over every window, by run [K]."""
        return [
            {name: values[WINDOW:] - values[:-WINDOW] for name, values in table.items()}
            for _, table in self._grids
        ]

    def moved(self, place: int, column: str, start_s: float, end_s: float) -> float:
        """Return by how much a thermometer moved in a span of a run, predicted by the others [K].

        A ridge regression of its changes over half an hour on those of all others, fitted outside
        the span, is summed over the span. 0 if there is too little to learn from, or if the sum is
        within its own error.
        """
        having = [run for run, table in enumerate(self._changes) if column in table]
        grid, here = self._grids[place]
        others = [n for n in here if n != column and all(n in self._changes[r] for r in having)]
        if len(others) < 2 or not len(grid):
            return 0.0
        inside = (grid >= start_s) & (grid <= end_s)
        learnt_x, learnt_y = [], []
        for run in having:
            table = self._changes[run]
            changes = np.column_stack([table[name] for name in (*others, column)])
            if run == place:
                changes[inside[WINDOW:] | inside[:-WINDOW], -1] = np.nan
            changes = changes[np.isfinite(changes).all(axis=1)]
            learnt_x.append(changes[:, :-1])
            learnt_y.append(changes[:, -1])
        x, y = np.concatenate(learnt_x), np.concatenate(learnt_y)
        wanted = np.diff(np.column_stack([here[name][inside] for name in others])[::WINDOW], axis=0)
        wanted = wanted[np.isfinite(wanted).all(axis=1)]
        if len(y) <= len(others) or not len(wanted):
            return 0.0
        weights, error = _learnt(x, y)
        moved = float(np.ptp(np.r_[0.0, np.cumsum(wanted @ weights)]))
        sure = float(-ndtri(WRONG / 2.0)) * error * np.sqrt(len(wanted))
        return moved if moved >= sure else 0.0


def _learnt(x: FloatArray, y: FloatArray) -> tuple[FloatArray, float]:
    """Return the weights of the others and the cross-validated error of one change [K]."""
    halves = np.array_split(np.arange(len(y)), 4)
    missed = []
    for half in halves:
        rest = np.setdiff1d(np.arange(len(y)), half)
        missed.append(y[half] - x[half] @ _ridge(x[rest], y[rest]))
    return _ridge(x, y), float(np.sqrt(np.mean(np.concatenate(missed) ** 2)))


def _ridge(x: FloatArray, y: FloatArray) -> FloatArray:
    # The reading uncertainty at both ends of a change damps the weights.
    errors = 2.0 * FINEST_K**2 * len(x) * np.eye(x.shape[1])
    return np.asarray(np.linalg.solve(x.T @ x + errors, x.T @ y))


def _on(grid: FloatArray, run: Run, column: str) -> FloatArray:
    rows, values = valid(run, column)
    if not values.size:
        return np.full(len(grid), np.nan)
    return np.interp(grid, run.time_s[rows], values)
