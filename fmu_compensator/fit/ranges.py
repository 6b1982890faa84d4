"""Plausible readings and limits of a compensator, from the data."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from fmu_compensator.fit.data import PreparedRun
from fmu_compensator.fit.training import Array, TrainingRun
from fmu_compensator.runtime.checks import SPAN_S
from fmu_compensator.runtime.geometry import FivePoint, Geometry
from fmu_packaging.variables import LONGEST_TOOL_MM
from measurement.errors import BadInput
from measurement.faults.checks.standing import FROZEN_S
from measurement.faults.series import UNUSUALLY, longest_unchanged
from measurement.resampling import GAP_INTERVALS
from measurement.units import UNITS

PLAUSIBLE_MARGIN_K = 25.0
"""A reading may lie this far outside the range seen in training: a hotter hall, a longer day [K].
Set on no data."""
RATE_QUANTILE = 0.999
"""The fastest one in a thousand changes in the training data are taken for faults [1]: set on no
data."""
LOWEST_RATE, LOWEST_NOISE_K = 0.05, 0.5
"""Lower bounds of the limits, whatever training saw: 3 K a minute, which a cooler switching on or a
door opening can cause at any thermometer [K/s]; then [K]. Set on no data."""
DEFAULT_LIMITS = {"slew_um_per_s": 1.0, "hold_s": 300.0, "recover_s": 10.0, "share": 1.0}
"""1 um/s is the rate at which a well-known control tracks thermal offsets."""


def sensor_table(name: str, runs: Sequence[PreparedRun], index: int) -> dict[str, Any]:
    """Return a sensor's entry of the compensator file, from all runs' readings.

    Parameters
    ----------
    name : str
        The sensor's signal name.
    runs : sequence of PreparedRun
        The training runs.
    index : int
        The sensor's column in them.
    """
    readings = [run.readings[:, index] for run in runs]
    low, high = _extremes(readings)
    trained_low, trained_high = _extremes([run.inputs[:, index] for run in runs])
    still = max(
        max(longest_unchanged(run.time_s, values), _interval(run.time_s, values))
        for run, values in zip(runs, readings, strict=True)
    )
    return {
        "name": name,
        "unit": "degC",
        "low": max(math.floor(low - PLAUSIBLE_MARGIN_K), UNITS["degC"].low),
        "high": min(math.ceil(high + PLAUSIBLE_MARGIN_K), UNITS["degC"].high),
        "rate_per_s": _rounded(max(UNUSUALLY * _fastest(runs, readings), LOWEST_RATE)),
        "noise": _rounded(max(UNUSUALLY * _largest_jump(readings), LOWEST_NOISE_K)),
        # At 3 intervals, thermometers in four sound runs of the lathe were stale for 1 to 8 % of
        # the time.
        "stale_after_s": math.ceil(max(GAP_INTERVALS * still, FROZEN_S)),
        "trained_low": _rounded(trained_low),
        "trained_high": _rounded(trained_high),
    }


def limits_table(
    geometry: Geometry,
    runs: Sequence[TrainingRun],
    tool_length_mm: tuple[float, float] | None,
    given: Mapping[str, float],
) -> dict[str, Any]:
    """Return the limits of the compensator file.

    Parameters
    ----------
    geometry : Geometry
        Turns targets into drift.
    runs : sequence of TrainingRun
        Their measured targets show how large the drift gets.
    tool_length_mm : tuple of float, optional
        Shortest and longest tool. By default from the gauge line to twice as far as the outer
        radial sensors: within their span and a little beyond.
    given : mapping
        Limits set by the caller; the others get defaults.

    Raises
    ------
    BadInput
        For an unknown limit, or a tool length that no compensator allows.
    """
    for name in given:
        if name not in {"offset_um", *DEFAULT_LIMITS}:
            raise BadInput("limits", name, "is not a known limit")
    low, high = tool_length_mm or _default_tool_length(geometry)
    if not -LONGEST_TOOL_MM <= low <= high <= LONGEST_TOOL_MM:
        allowed = f"shortest and longest, within {-LONGEST_TOOL_MM:g} to {LONGEST_TOOL_MM:g} mm"
        raise BadInput("fit", "tool length", f"{low:g} {high:g} is not allowed: {allowed}")
    largest = max(
        abs(value)
        for run in runs
        for targets in _corners(run.targets)
        for value in geometry.drift(targets, high)
    )
    # Rounded up to a multiple of 5 um, because people read this setting.
    offset = 5.0 * math.ceil(UNUSUALLY * largest / 5.0)
    limits = {"offset_um": offset, **DEFAULT_LIMITS, **given}
    return {**limits, "tool_length_mm": [low, high]}


def _default_tool_length(geometry: Geometry) -> tuple[float, float]:
    if not isinstance(geometry, FivePoint):
        return 0.0, LONGEST_TOOL_MM
    near = geometry.near_to_gauge_mm
    outer = max(near, near + geometry.spacing_mm)
    return 0.0, min(max(2.0 * outer, 100.0), LONGEST_TOOL_MM)


def _corners(targets: Array) -> list[list[float]]:
    """Return the rows in which some target is smallest or largest, and both extreme rows.

    The drift is monotonic in each target, so no row drifts further than the extreme corner.
    """
    if len(targets) == 0:
        return [[0.0] * targets.shape[1]]
    return [targets.max(axis=0).tolist(), targets.min(axis=0).tolist()]


def _extremes(columns: Sequence[Array]) -> tuple[float, float]:
    values = np.concatenate(columns)
    return float(np.nanmin(values)), float(np.nanmax(values))


def _interval(time_s: Array, values: Array) -> float:
    """Return a sensor's sampling interval [s]: between two readings it is constant."""
    known = time_s[np.isfinite(values)]
    return float(np.median(np.diff(known))) if len(known) > 1 else 0.0


def _fastest(runs: Sequence[PreparedRun], readings: Sequence[Array]) -> float:
    """Return the fastest change over `SPAN_S` without outliers [K/s]."""
    rates = []
    for run, values in zip(runs, readings, strict=True):
        there = np.isfinite(values)
        time = run.time_s[there]
        if len(time) < 2:
            continue
        if time[-1] - time[0] <= SPAN_S:
            rates.append(np.array([abs(values[there][-1] - values[there][0]) / SPAN_S]))
            continue
        start = np.arange(time[0], time[-1] - SPAN_S, SPAN_S / 5)
        change = np.interp(start + SPAN_S, time, values[there])
        rates.append(np.abs(change - np.interp(start, time, values[there])) / SPAN_S)
    return float(np.quantile(np.concatenate(rates), RATE_QUANTILE)) if rates else 0.0


def _largest_jump(readings: Sequence[Array]) -> float:
    """Return the largest change between consecutive samples without outliers [K]."""
    jumps = np.concatenate([np.abs(np.diff(values[np.isfinite(values)])) for values in readings])
    return float(np.quantile(jumps, RATE_QUANTILE)) if len(jumps) else 0.0


def _rounded(value: float) -> float:
    return float(f"{value:.6g}")
