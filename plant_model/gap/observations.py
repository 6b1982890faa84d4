"""What calibration and the gap finder compare: measured runs as weighted observations.

Rows are gathered into bins of a minute, so that sampling does not decide how much a run counts:
each channel of a run weighs as many independent values as it has half hours. Readings near a speed
change are trusted less the longer the sampling interval, because the instant of the change is
known no better than that.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from measurement.errors import BadInput
from measurement.runs import Run
from plant_model.machine import Machine
from plant_model.parameters import FloatArray
from plant_model.sensors import column_of, displacement_names, noise_and_resolution

BIN_S = 60.0
"""Width of a bin [s]."""

INDEPENDENT_S = 1800.0
"""Time after which a misfit is new evidence [s]: misfits of lumped models last that long."""

TEMPERATURE_TOLERANCE = 0.1
DISPLACEMENT_TOLERANCE = 0.5
"""What a good lumped model may be wrong by, beside noise [K, um]."""

RELATIVE_TOLERANCE = 0.02
"""And in proportion to how much the channel moves in the runs [1]."""


@dataclass(frozen=True)
class Observations:
    """One run's observations.

    Attributes
    ----------
    run : Run
        Its frame drives the simulation.
    time_s : array, shape (K,)
        Mean time of the rows in each bin [s].
    channels : tuple of str
        Sensor names, temperatures first.
    values : array, shape (K, C)
        Measured [degC, um]; NaN where missing. Displacements start at zero.
    weights : array, shape (K, C)
        One over the tolerance, scaled so that a channel weighs its independent values; 0 where
        there is nothing to compare.
    tolerance : array, shape (C,)
        Of each channel [K, um].
    """

    run: Run
    time_s: FloatArray
    channels: tuple[str, ...]
    values: FloatArray
    weights: FloatArray
    tolerance: FloatArray

    def weighted(self, modelled: FloatArray) -> FloatArray:
        """Return weighted model minus measurement, shape (..., K C), from (..., K, C)."""
        difference = (modelled - np.nan_to_num(self.values)) * self.weights
        return difference.reshape(*modelled.shape[:-2], -1)


def compared_channels(machine: Machine, runs: Sequence[Run]) -> tuple[str, ...]:
    """Return the sensors that the machine has and the runs hold, boundary readings left out.

    Raises
    ------
    BadInput
        If no channel is left to compare.
    """
    columns = set().union(*(run.frame.columns for run in runs))
    driving = {entry.column for entry in machine.inputs}
    names = [sensor.name for sensor in machine.sensors] + displacement_names(machine)
    found = tuple(name for name in names if column_of(machine, name) in columns - driving)
    if not found:
        wanted = ", ".join(column_of(machine, name) for name in names)
        raise BadInput(
            runs[0].path or runs[0].name, "", f"has no column to compare; one of {wanted}"
        )
    return found


def observe(
    machine: Machine,
    runs: Sequence[Run],
    bad: dict[str, list[tuple[str, float, float]]] | None = None,
) -> list[Observations]:
    """Gather the observations of some runs.

    Parameters
    ----------
    machine : Machine
        Says which column is which sensor's.
    runs : sequence of Run
    bad : dict of run name to list of (channel, start, end), optional
        Spans to leave out [s].

    Raises
    ------
    BadInput
        When a run has no usable rows or no channel.
    """
    channels = compared_channels(machine, runs)
    binned = [_binned(machine, run, channels, (bad or {}).get(run.name, [])) for run in runs]
    together = np.concatenate([values for _, values in binned])
    span = _span(together)
    lengths = np.array([name in displacement_names(machine) for name in channels])
    table = noise_and_resolution(machine)
    noise = np.array([np.hypot(table[n][0], table[n][1] / np.sqrt(12.0)) for n in channels])
    own = np.where(lengths, DISPLACEMENT_TOLERANCE, TEMPERATURE_TOLERANCE)
    tolerance = np.sqrt(noise**2 + own**2 + (RELATIVE_TOLERANCE * span) ** 2)
    found = []
    for run, (time, values) in zip(runs, binned, strict=True):
        extra = _switch_uncertainty(machine, run, time, values)
        sigma = np.sqrt(tolerance**2 + extra**2)
        present = np.isfinite(values)
        weights = np.where(present, 1.0 / sigma, 0.0)
        covered = present.sum(axis=0) * _median_step(time)
        share = np.maximum(covered / INDEPENDENT_S, 1.0) / np.maximum(present.sum(axis=0), 1)
        found.append(Observations(run, time, channels, values, weights * np.sqrt(share), tolerance))
    return found


def _median_step(time: FloatArray) -> float:
    return float(np.median(np.diff(time))) if len(time) > 1 else BIN_S


def _span(values: FloatArray) -> FloatArray:
    with np.errstate(all="ignore"):
        low, high = np.nanpercentile(np.where(np.isfinite(values), values, np.nan), [2, 98], axis=0)
    return np.asarray(np.nan_to_num(high - low))


def _binned(
    machine: Machine, run: Run, channels: tuple[str, ...], bad: list[tuple[str, float, float]]
) -> tuple[FloatArray, FloatArray]:
    """Return bin times and mean values, displacements from zero."""
    rows = run.time_s
    if len(rows) < 3:
        raise BadInput(run.path or run.name, "", "has fewer than three rows")
    which = np.floor((rows - rows[0]) / BIN_S).astype(int)
    _, which, counts = np.unique(which, return_inverse=True, return_counts=True)
    time = np.bincount(which, rows) / counts
    values = np.full((len(time), len(channels)), np.nan)
    for i, name in enumerate(channels):
        column = column_of(machine, name)
        if column not in run.frame.columns:
            continue
        series = run.frame[column].to_numpy(dtype=np.float64).copy()
        for channel, start, end in bad:
            if channel == name:
                series[(rows >= start) & (rows <= end)] = np.nan
        good = np.isfinite(series)
        if not good.any():
            continue
        n = np.bincount(which[good], minlength=len(time))
        total = np.bincount(which[good], series[good], minlength=len(time))
        values[:, i] = np.where(n > 0, total / np.maximum(n, 1), np.nan)
        if column.endswith("_um"):
            values[:, i] -= series[good][0]
    return time, values


def _switch_uncertainty(
    machine: Machine, run: Run, time: FloatArray, values: FloatArray
) -> FloatArray:
    """Return how far a reading may be off because a switch's instant is not known, (K, C)."""
    rows = run.time_s
    extra = np.zeros_like(values)
    for entry in machine.inputs:
        if entry.is_boundary or entry.column not in run.frame.columns:
            continue
        held = run.frame[entry.column].ffill().bfill().to_numpy(dtype=np.float64)
        jumps = np.flatnonzero(np.abs(np.diff(held)) > 0.02 * (entry.high - entry.low))
        for j in jumps:
            interval = rows[j + 1] - rows[j]
            near = (time > rows[j] - BIN_S) & (time < rows[j + 1] + 3.0 * max(interval, BIN_S))
            rate = (
                np.abs(np.gradient(np.nan_to_num(values[near]), time[near], axis=0))
                if (near.sum() > 1)
                else 0.0
            )
            extra[near] = np.maximum(extra[near], rate * max(interval, BIN_S) / 2.0)
    return extra
