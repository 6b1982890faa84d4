"""What a broken thermometer is likely to read, given the others: the fitting twin."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from fmu_compensator.fit.data import PreparedRun
from fmu_compensator.fit.error_models.base import FittedModel
from fmu_compensator.fit.guarding import likeliest_memory, rows_apart, usual_drift
from fmu_compensator.fit.intervals import axis_drift
from fmu_compensator.fit.training import Array, TrainingRun
from fmu_compensator.fit.unseen import DEVIATIONS
from fmu_compensator.runtime.geometry import Geometry

NOISE_K = 0.05
"""No thermometer is believed to agree with the others better than this [K]."""
STRENGTHS = np.logspace(-6.0, 1.0, 22)
"""Shares of the mean variance that are tried as the variance of what is a sensor's own [1]."""
MOST_SENSORS = 200
"""With more chosen sensors the file would be all precision matrix."""
MOST_ROWS = 120
MOST_RUNS = 8
"""So many runs, evenly chosen, tell how far an error of a reading moves the drift."""


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
        The same rows as an error model takes them in.
    """

    hours: Array
    values: Array
    rows: TrainingRun

    @classmethod
    def of(cls, run: PreparedRun, chosen: Sequence[int]) -> Rises | None:
        """Return at most about `MOST_ROWS` of the rows with all chosen temperatures."""
        columns = list(chosen)
        there = np.flatnonzero(np.isfinite(run.inputs[:, columns]).all(axis=1))
        if len(there) < 2:
            return None
        kept = np.zeros(len(there), dtype=bool)
        kept[:: max(len(there) // MOST_ROWS, 1)] = True
        values = run.temperatures[there][:, columns]
        rows = run.history(columns).at(kept)
        hours = (rows.time_s - rows.time_s[0]) / 3600.0
        return cls(hours, (values - values[0])[kept], rows)


def precision(runs: Sequence[Array], strength: float) -> Array:
    """Return the precision matrix of rises, shape (k, k) [1/K^2].

    Parameters
    ----------
    runs : sequence of array (n, k)
        Rises [K]; every run counts as one, whatever its rows.
    strength : float
        Variance of what is a sensor's own, over the mean variance [1].
    """
    together = np.mean([one.T @ one / len(one) for one in runs], axis=0)
    own = strength * np.trace(together) / len(together) + NOISE_K**2
    found = np.linalg.inv(together + own * np.eye(len(together)))
    return np.asarray((found + found.T) / 2.0)


def left_out_errors(runs: Sequence[Array], strength: float) -> list[Array]:
    """Return how far each reading is from what all others say, each run by the other runs [K]."""
    found = []
    for place, one in enumerate(runs):
        known = precision([*runs[:place], *runs[place + 1 :]], strength)
        found.append(one @ known / np.diag(known))
    return found


def best_strength(runs: Sequence[Array]) -> float:
    """Return which of `STRENGTHS` says best what a sensor of a run left out reads.

    The mean of logarithms: one run with a broken sensor does not decide.

    Parameters
    ----------
    runs : sequence of array, each (rows, sensors)
        Temperatures [degC or K].
    """

    def missed(strength: float) -> float:
        errors = left_out_errors(runs, strength)
        return float(np.mean([np.log((e**2).mean(axis=0) + NOISE_K**2) for e in errors]))

    return float(min(STRENGTHS, key=missed))


def spare_table(
    runs: Sequence[PreparedRun],
    chosen: Sequence[int],
    fitted: FittedModel,
    geometry: Geometry,
    tool_length_mm: Sequence[float],
) -> dict[str, Any] | None:
    """Return the file's table; None where one sensor cannot be told from others.

    That is with one run, as nothing is left to try it on, with one sensor, and with more than
    `MOST_SENSORS`.

    Parameters
    ----------
    runs : sequence of PreparedRun
        All training runs.
    chosen : sequence of int
        The error model's sensors.
    fitted : FittedModel
        The error model.
    geometry : Geometry
        From targets to drift.
    tool_length_mm : sequence of float
        Shortest and longest tool.
    """
    records = [one for one in (Rises.of(run, chosen) for run in runs) if one is not None]
    if len(records) < 2 or not 2 <= len(chosen) <= MOST_SENSORS:
        return None
    rises = [one.values for one in records]
    strength = best_strength(rises)
    known = precision(rises, strength)
    errors = left_out_errors(rises, strength)
    variance = np.mean([(one**2).mean(axis=0) for one in errors], axis=0)
    moved = _moved(records, errors, fitted, geometry, tool_length_mm)
    rows = [run.history(chosen) for run in runs]
    usual = np.sqrt(usual_drift(rows, geometry, tool_length_mm))
    return {
        "precision": [[_plain(value) for value in row] for row in known.tolist()],
        "growth": [_plain(value) for value in variance * np.diag(known)],
        "memory_s": 3600.0 * likeliest_memory(_series(records, errors, variance)),
        "deviations": _plain(DEVIATIONS),
        "shortest_tool_um_per_K": [[_plain(value) for value in row] for row in moved[:3]],
        "longest_tool_um_per_K": [[_plain(value) for value in row] for row in moved[3:]],
        "shortest_tool_usual_um": [_plain(value) for value in usual[:3]],
        "longest_tool_usual_um": [_plain(value) for value in usual[3:]],
    }


def _series(
    records: Sequence[Rises], errors: Sequence[Array], variance: Array
) -> list[tuple[Array, Array]]:
    size = np.sqrt(np.maximum(variance, NOISE_K**2))
    found = []
    for record, error in zip(records, errors, strict=True):
        kept = rows_apart(record.hours)
        found.append((record.hours[kept], error[kept] / size))
    return [(hours, values) for hours, values in found if len(hours) > 1]


def _moved(
    records: Sequence[Rises],
    errors: Sequence[Array],
    fitted: FittedModel,
    geometry: Geometry,
    tool_length_mm: Sequence[float],
) -> Array:
    """Return how far the drift moves with each sensor's error, shape (6, k) [um/K].

    By the error model itself, memory and all: root mean square of the drift's change over that of
    the error, X, Y, Z at the shortest tool, then at the longest.
    """
    few = np.unique(np.linspace(0, len(records) - 1, MOST_RUNS).astype(int))
    count = errors[0].shape[1]
    change, wrong, along = np.zeros((6, count)), np.zeros(count), np.zeros((6, count))
    for place in few:
        rows, error = records[place].rows, errors[place]
        usual = fitted.predict(rows)
        for sensor in range(count):
            inputs = rows.inputs.copy()
            inputs[:, sensor] += error[:, sensor]
            targets = fitted.predict(replace(rows, inputs=inputs)) - usual
            drift = np.hstack([axis_drift(geometry, targets, one) for one in tool_length_mm])
            change[:, sensor] += (drift**2).mean(axis=0)
            wrong[sensor] += (error[:, sensor] ** 2).mean()
            along[:, sensor] += (drift * error[:, [sensor]]).mean(axis=0)
    return np.asarray(np.sign(along) * np.sqrt(change / np.maximum(wrong, 1e-12)))


def _plain(value: float) -> float:
    return float(f"{value:.9g}")
