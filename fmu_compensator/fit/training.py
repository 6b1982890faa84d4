"""Runs prepared for fitting: joined columns, relative to their start, weighted by time."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from measurement.resampling import recorded_steps

Array = NDArray[np.float64]
GRID_S = 60.0
"""Rows closer together add no information about drift [s]: set on no data."""


@dataclass(frozen=True)
class TrainingRun:
    """One run's rows, each with complete inputs.

    Rows for a model that remembers earlier samples (`PreparedRun.history`) have targets only
    where they were measured; those for any other model (`PreparedRun.complete`) always have them.

    Attributes
    ----------
    name : str
        The run's name.
    time_s : array (n,)
        Time [s].
    inputs : array (n, k)
        Temperatures, in the input form [degC or K].
    targets : array (n, m)
        Values to predict; NaN if not measured [um, urad].
    speed : array (n,)
        Spindle speed [rpm]; NaN if not recorded.
    weights : array (n,)
        The time that each row represents; 0 if a target is missing [s].
    """

    name: str
    time_s: Array
    inputs: Array
    targets: Array
    speed: Array
    weights: Array

    @property
    def known(self) -> NDArray[np.bool_]:
        """Whether each row has all targets."""
        return np.asarray(np.isfinite(self.targets).all(axis=1))

    @property
    def held_speed(self) -> Array:
        """The speed that held until each row, without its sign: 0 before the first known [rpm]."""
        speeds = pd.Series(np.where(np.isfinite(self.speed), np.abs(self.speed), np.nan))
        return np.asarray(speeds.shift().ffill().fillna(0.0), dtype=np.float64)

    def at(self, rows: NDArray[np.bool_]) -> TrainingRun:
        """Return the same run with some of its rows.

        Parameters
        ----------
        rows : array of bool, shape (n,)
            Which to keep.
        """
        return TrainingRun(
            self.name,
            self.time_s[rows],
            self.inputs[rows],
            self.targets[rows],
            self.speed[rows],
            self.weights[rows],
        )

    def of(self, columns: list[int]) -> TrainingRun:
        """Return the same run with some of its inputs.

        Parameters
        ----------
        columns : list of int
            Positions of the inputs to keep, in the order wanted.
        """
        return TrainingRun(
            self.name, self.time_s, self.inputs[:, columns], self.targets, self.speed, self.weights
        )


def row_weights(time_s: Array) -> Array:
    """Return the time that each row represents [s]: half the interval to either neighbour.

    These weights make a run count by its duration, not by its sampling. Rows next to a pause do
    not represent it: see `recorded_steps`.

    Parameters
    ----------
    time_s : array, shape (n,)
        Increasing [s].

    Returns
    -------
    array, shape (n,)
        [s]; a single row weighs 1.
    """
    if len(time_s) < 2:
        return np.ones(len(time_s))
    gaps = recorded_steps(time_s)
    weights = np.zeros(len(time_s))
    weights[:-1] += gaps / 2
    weights[1:] += gaps / 2
    return weights
