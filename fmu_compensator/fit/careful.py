"""The careful model that a compensator's guard holds: its fitting twin."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from fmu_compensator.fit.data import PreparedRun
from fmu_compensator.fit.evidence import Posterior, posterior
from fmu_compensator.fit.lagged import lagged
from fmu_compensator.fit.training import Array
from fmu_compensator.runtime.guard import LEVEL_FAULT_K, LONE
from measurement.errors import BadInput

LAGS_S = (2400.0,)
"""One lag, in the middle of the time constants of spindle parts, keeps a step cheap [s]."""


@dataclass(frozen=True)
class CarefulModel:
    """See `fmu_compensator.runtime.guard.Guard` for the equation.

    Attributes
    ----------
    fixed : bool
        Whether rises count from fixed temperatures: the drift is absolute then.
    usual : array (k,)
        Usual first reading above the median of all [K], or the fixed reference [degC].
    constant : array (m,)
        Mean target of the absolute form, else zeros [um, urad].
    posterior : Posterior
        Of the weights.
    """

    fixed: bool
    usual: Array
    constant: Array
    posterior: Posterior

    @classmethod
    def fit(
        cls, runs: Sequence[PreparedRun], chosen: Sequence[int], input_form: str
    ) -> CarefulModel:
        """Return the model fitted to some runs.

        Raises
        ------
        BadInput
            If no run has a row with all readings and targets.
        """
        columns = list(chosen)
        rows = [(run, run.history(columns)) for run in runs]
        rows = [(run, kept) for run, kept in rows if kept.known.any()]
        if not rows:
            raise BadInput("training runs", "", "no row has all temperatures and displacements")
        readings = [_readings(run, columns) for run, _ in rows]
        fixed = input_form == "absolute"
        targets = [kept.targets[kept.known] for _, kept in rows]
        if fixed:
            usual = np.mean([one.mean(axis=0) for one in readings], axis=0)
            constant = np.mean([one.mean(axis=0) for one in targets], axis=0)
        else:
            starts = [one[0] - np.median(one[0]) for one in readings]
            usual, constant = np.median(starts, axis=0), np.zeros(targets[0].shape[1])
        features = [
            _features(one, kept.time_s, usual, fixed)[kept.known]
            for one, (_, kept) in zip(readings, rows, strict=True)
        ]
        return cls(fixed, usual, constant, posterior(features, [y - constant for y in targets]))

    def predict(self, run: PreparedRun, chosen: Sequence[int]) -> tuple[Array, Array]:
        """Return targets (n, m) and novelty (n,) for the rows of ``run.history(chosen)``."""
        columns = list(chosen)
        time_s = run.history(columns).time_s
        features = _features(_readings(run, columns), time_s, self.usual, self.fixed)
        values = self.constant + features @ self.posterior.weights
        return values, self.posterior.leverage(features)

    def table(self) -> dict[str, Any]:
        """Return the guard's numbers for the compensator file that are the model's own."""
        count = len(self.usual)
        weights = self.posterior.weights.T
        parts = [weights[:, at : at + count].tolist() for at in range(0, weights.shape[1], count)]
        return {
            "lags_s": list(LAGS_S),
            "reference": "fixed" if self.fixed else "start",
            "usual": self.usual.tolist(),
            "constant": self.constant.tolist(),
            "direct": parts[0],
            "rise_lags": parts[1::2],
            "start_lags": parts[2::2],
            "prior": 1.0 / self.posterior.ratio,
            "seen": self.posterior.seen.tolist(),
        }


def _readings(run: PreparedRun, columns: Sequence[int]) -> Array:
    """Return the chosen temperatures of the rows of ``run.history`` [degC]."""
    rows = np.isfinite(run.inputs[:, columns]).all(axis=1)
    return run.temperatures[rows][:, columns]


def _believed(start: Array) -> Array:
    """Return how far the first readings are from their usual places; 0 for a lone wrong level."""
    away = np.sort(np.abs(start))
    if len(away) > 1 and away[-1] > LEVEL_FAULT_K and away[-1] > LONE * away[-2]:
        return np.where(np.abs(start) == away[-1], 0.0, start)
    return start


def _features(readings: Array, time_s: Array, usual: Array, fixed: bool) -> Array:
    """Return rises, then for each lag the lagged rises and starts, shape (n, k (1 + 2 lags))."""
    if fixed:
        rises, start = readings - usual, np.zeros(readings.shape[1])
    else:
        rises = readings - readings[0]
        start = _believed(readings[0] - np.median(readings[0]) - usual)
    drives = np.hstack([rises, np.broadcast_to(start, rises.shape)])
    elapsed = np.diff(time_s, prepend=time_s[0])
    return np.hstack([rises, *(lagged(drives, elapsed, lag) for lag in LAGS_S)])
