"""Fits the model that estimates the reading of a broken thermometer from the others."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np

from fmu_compensator.fit.data import PreparedRun
from fmu_compensator.fit.features import LAGS_S, spread_rows
from fmu_compensator.fit.installed import Installed, listed
from fmu_compensator.fit.training import Array, TrainingRun
from measurement.resampling import FINEST_K

NOISE_K = FINEST_K / 2.0
"""Lower limit of a thermometer's deviation from the others [K]: rounding makes as much."""
STRENGTHS = np.logspace(-6.0, 1.0, 22)
"""Shares of the mean variance to try as the variance of each sensor that is independent of the
others [1]."""


@dataclass(frozen=True)
class Rises:
    """One run's chosen temperatures.

    Attributes
    ----------
    hours : array (n,)
        Time since its start [h].
    values : array (n, k)
        Rises above the first row [K].
    rows : TrainingRun
        The same rows as input of an error model.
    """

    hours: Array
    values: Array
    rows: TrainingRun

    @classmethod
    def of(cls, run: PreparedRun, chosen: Sequence[int]) -> Rises | None:
        """Return the first and up to `MOST_ROWS` further rows with all chosen temperatures."""
        columns = list(chosen)
        there = np.isfinite(run.inputs[:, columns]).all(axis=1)
        if there.sum() < 2:
            return None
        values, rows = run.temperatures[there][:, columns], run.history(columns)
        hours = (rows.time_s - rows.time_s[0]) / 3600.0
        kept = np.isin(np.arange(len(hours)), [0, *spread_rows(hours, np.isfinite(hours))])
        return cls(hours[kept], (values - values[0])[kept], rows.at(kept))

    @classmethod
    def of_all(cls, runs: Sequence[PreparedRun], chosen: Sequence[int]) -> list[Rises]:
        """Return the rises of all runs that have any."""
        return [record for run in runs if (record := cls.of(run, chosen)) is not None]


def precision(runs: Sequence[Array], strength: float) -> Array:
    """Return the precision matrix of rises, shape (k, k) [1/K^2].

    Parameters
    ----------
    runs : sequence of array (n, k)
        Rises [K]; every run has the same weight, whatever its number of rows.
    strength : float
        Variance of each sensor independent of the others, over the mean variance [1].
    """
    together = np.mean([rises.T @ rises / len(rises) for rises in runs], axis=0)
    own = strength * np.trace(together) / len(together) + NOISE_K**2
    return _inverse(together + own * np.eye(len(together)))


def _inverse(covariance: Array) -> Array:
    """Return the inverse of a symmetric matrix, symmetric to the last digit."""
    inverse = np.linalg.inv(covariance)
    return np.asarray((inverse + inverse.T) / 2.0)


def left_out_errors(runs: Sequence[Array], strength: float) -> list[Array]:
    """Return each reading's deviation from its estimate by the others, fitted to other runs [K]."""
    return _left_out(runs, partial(precision, strength=strength))


def _left_out(runs: Sequence[Array], known_from: Callable[[Sequence[Array]], Array]) -> list[Array]:
    """Return the same for any way from runs to their precision matrix."""
    errors = []
    for place, rises in enumerate(runs):
        inverse = known_from([*runs[:place], *runs[place + 1 :]])
        errors.append(np.asarray(rises @ inverse / np.diag(inverse)))
    return errors


def best_strength(runs: Sequence[Array]) -> float:
    """Return which of `STRENGTHS` predicts the sensors of left-out runs best.

    Logarithms are averaged, so that one run with a broken sensor does not decide.

    Parameters
    ----------
    runs : sequence of array, each (rows, sensors)
        Temperatures [degC or K].
    """

    def missed(strength: float) -> float:
        errors = left_out_errors(runs, strength)
        return float(np.mean([np.log((e**2).mean(axis=0) + NOISE_K**2) for e in errors]))

    return float(min(STRENGTHS, key=missed))


def spare_table(runs: Sequence[PreparedRun], installed: Installed) -> dict[str, Any] | None:
    """Return the file's table; None if a sensor cannot be estimated from others.

    That is with one run, because no run is left for testing, or with one sensor.

    Parameters
    ----------
    runs : sequence of PreparedRun
        All training runs.
    installed : Installed
        What was fitted to them.
    """
    chosen = installed.chosen
    records = Rises.of_all(runs, chosen)
    if len(records) < 2 or len(chosen) < 2:
        return None
    rises = [record.values for record in records]
    strength = best_strength(rises)
    inverse, errors = precision(rises, strength), left_out_errors(rises, strength)
    variance = np.mean([(error**2).mean(axis=0) for error in errors], axis=0)
    return {
        "precision": listed(inverse),
        "growth": listed(variance * np.diag(inverse)),
        "memory_s": 3600.0 * likeliest_memory(_series(records, errors, variance)),
        "usual_start": None if installed.usual is not None else listed(_usual_start(runs, chosen)),
        "sensitivity": listed(_sensitivity(records, errors, installed)),
    }


def spare_after(
    spare: Mapping[str, Any], runs: Sequence[PreparedRun], chosen: Sequence[int], before: int
) -> dict[str, Any]:
    """Return the file's table after further runs, with updated precision and growth.

    Parameters
    ----------
    spare : mapping
        The file's table.
    runs : sequence of PreparedRun
        Further runs.
    chosen : sequence of int
        Places of the compensator's sensors among the runs'.
    before : int
        Number of runs that the file is based on.
    """
    rises = [record.values for record in Rises.of_all(runs, chosen)]
    old = np.array(spare["precision"])

    def known_from(some: Sequence[Array]) -> Array:
        together = sum((run.T @ run / len(run) for run in some), before * np.linalg.inv(old))
        own = len(some) * NOISE_K**2  # that of the earlier runs is in their covariance
        return _inverse((together + own * np.eye(len(old))) / (before + len(some)))

    squares = before * np.array(spare["growth"]) / np.diag(old)
    squares = sum(((error**2).mean(axis=0) for error in _left_out(rises, known_from)), squares)
    known = known_from(rises)
    growth = squares / (before + len(rises)) * np.diag(known)
    return {**spare, "precision": listed(known), "growth": listed(growth)}


def _usual_start(runs: Sequence[PreparedRun], chosen: Sequence[int]) -> Array:
    """Return each sensor's usual first reading above the median of all, shape (k,) [K]."""
    columns = list(chosen)
    there = [run.temperatures[:, columns] for run in runs]
    first = [
        readings[np.isfinite(readings).all(axis=1)][0]
        for readings in there
        if np.isfinite(readings).all(axis=1).any()
    ]
    return np.asarray(np.median([reading - np.median(reading) for reading in first], axis=0))


def likeliest_memory(series: Sequence[tuple[Array, Array]]) -> float:
    """Return which of the Gaussian's lags describes series best [h].

    Parameters
    ----------
    series : sequence of (times (n,), values (n, m))
        [h], [1]
    """

    def likelihood(memory: float) -> float:
        total = 0.0
        for hours, values in series:
            kept = np.exp(-np.diff(hours) / memory)[:, None]
            step = values[1:] - kept * values[:-1]
            variance = np.maximum(1.0 - kept**2, 1e-6)
            size = np.maximum(np.mean(values**2, axis=0), 1e-6)
            total -= float(np.mean(step**2 / variance / size + np.log(variance)))
        return total

    return max((lag_s / 3600.0 for lag_s in LAGS_S), key=likelihood)


def _series(
    records: Sequence[Rises], errors: Sequence[Array], variance: Array
) -> list[tuple[Array, Array]]:
    size = np.sqrt(np.maximum(variance, NOISE_K**2))
    return [(record.hours, error / size) for record, error in zip(records, errors, strict=True)]


def _sensitivity(records: Sequence[Rises], errors: Sequence[Array], installed: Installed) -> Array:
    """Return how much the targets change with each sensor's error, shape (m, k) [um/K, urad/K].

    Computed with what is installed, including its memory: root mean square of the targets' change
    over that of the error.
    """
    count, targets = errors[0].shape[1], len(installed.constant)
    change, wrong, along = np.zeros((targets, count)), np.zeros(count), np.zeros((targets, count))
    for record, error in zip(records, errors, strict=True):
        rows, rises = record.rows, record.values
        usual = installed.values(rows, rises)
        for sensor in range(count):
            off = np.zeros_like(error)
            off[:, sensor] = error[:, sensor]
            moved = installed.values(replace(rows, inputs=rows.inputs + off), rises + off) - usual
            change[:, sensor] += (moved**2).mean(axis=0)
            wrong[sensor] += (error[:, sensor] ** 2).mean()
            along[:, sensor] += (moved * error[:, [sensor]]).mean(axis=0)
    return np.asarray(np.sign(along) * np.sqrt(change / np.maximum(wrong, 1e-12)))
