"""What the compensator will believe and do: plausible readings and limits, from the data."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from fmu_compensator.fit.data import PreparedRun
from fmu_compensator.fit.training import Array, TrainingRun
from fmu_compensator.runtime.geometry import LONGEST_TOOL_MM, FivePoint, Geometry
from measurement.errors import BadInput
from measurement.faults.series import longest_unchanged

PLAUSIBLE_MARGIN_K = 25.0
"""A reading may lie this far outside what training saw: a hotter hall, a longer day [K]."""
LOWEST_DEGC, HIGHEST_DEGC = -60.0, 400.0
RATE_SPAN_S = 300.0
"""Rates of change are taken over this span, in which noise and quantisation hardly count [s]."""
RATE_QUANTILE = 0.999
"""Faster changes than all but one in a thousand are taken for faults in the training data [1]."""
RATE_MARGIN, LOWEST_RATE = 3.0, 0.05
"""Factor on the fastest change seen [1]; the second is 3 K a minute, which a cooler that switches
on or a door that opens can bring to any thermometer, whatever training saw [K/s]."""
NOISE_MARGIN, LOWEST_NOISE_K = 3.0, 0.5
"""The same for the largest jump between two samples [1], [K]."""
STALE_MARGIN, SHORTEST_STALE_S, LONGEST_STALE_S = 5.0, 900.0, 7200.0
"""Factor on the longest standstill of a reading seen [1]; a limit is at least the second [s]. A
sensor that stood still for longer than the third in training is too coarse to be watched [s]."""
TRAINED_MARGIN, SMALLEST_TRAINED_MARGIN_K = 0.05, 0.3
"""The trained range is widened by this share of itself [1], at least by the second [K]."""
OFFSET_MARGIN, SMALLEST_OFFSET_UM = 2.0, 20.0
"""Factor on the largest drift seen, at the longest tool [1]; at least the second [um]."""
DEFAULT_LIMITS = {"slew_um_per_s": 1.0, "hold_s": 300.0, "recover_s": 10.0, "share": 1.0}
"""1 um/s is what a well-known control tracks thermal offsets at."""


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
    margin = max(TRAINED_MARGIN * (trained_high - trained_low), SMALLEST_TRAINED_MARGIN_K)
    still = max(
        max(longest_unchanged(run.time_s, values), _interval(run.time_s, values))
        for run, values in zip(runs, readings, strict=True)
    )
    stale = max(STALE_MARGIN * still, SHORTEST_STALE_S) if still <= LONGEST_STALE_S else None
    return {
        "name": name,
        "unit": "degC",
        "low": max(math.floor(low - PLAUSIBLE_MARGIN_K), LOWEST_DEGC),
        "high": min(math.ceil(high + PLAUSIBLE_MARGIN_K), HIGHEST_DEGC),
        "rate_per_s": _rounded(max(RATE_MARGIN * _fastest(runs, readings), LOWEST_RATE)),
        "noise": _rounded(max(NOISE_MARGIN * _largest_jump(readings), LOWEST_NOISE_K)),
        "stale_after_s": None if stale is None else math.ceil(stale),
        "trained_low": _rounded(trained_low - margin),
        "trained_high": _rounded(trained_high + margin),
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
        Their measured targets say how large a drift gets.
    tool_length_mm : tuple of float, optional
        Shortest and longest tool. By default from the gauge line to twice as far as the outer
        radial sensors: within their span and a little beyond.
    given : mapping
        Limits that the caller sets; the others are defaults.

    Raises
    ------
    BadInput
        For a limit that is not known, or a tool length that no compensator allows.
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
    offset = max(OFFSET_MARGIN * largest, SMALLEST_OFFSET_UM)
    # Rounded up to whole 5 um: a limit is a setting that people read.
    limits = {"offset_um": 5.0 * math.ceil(offset / 5.0), **DEFAULT_LIMITS, **given}
    return {**limits, "tool_length_mm": [low, high]}


def _default_tool_length(geometry: Geometry) -> tuple[float, float]:
    if not isinstance(geometry, FivePoint):
        return 0.0, LONGEST_TOOL_MM
    near = geometry.near_to_gauge_mm
    outer = max(near, near + geometry.spacing_mm)
    return 0.0, min(max(2.0 * outer, 100.0), LONGEST_TOOL_MM)


def _corners(targets: Array) -> list[list[float]]:
    """Return the rows in which some target is smallest or largest, and both extreme rows.

    The drift is monotonic in each target, so no row drifts further than the corner of extremes.
    """
    if len(targets) == 0:
        return [[0.0] * targets.shape[1]]
    return [targets.max(axis=0).tolist(), targets.min(axis=0).tolist()]


def _extremes(columns: Sequence[Array]) -> tuple[float, float]:
    values = np.concatenate(columns)
    return float(np.nanmin(values)), float(np.nanmax(values))


def _interval(time_s: Array, values: Array) -> float:
    """Return how often a sensor is read [s]: between two readings it stands still."""
    known = time_s[np.isfinite(values)]
    return float(np.median(np.diff(known))) if len(known) > 1 else 0.0


def _fastest(runs: Sequence[PreparedRun], readings: Sequence[Array]) -> float:
    """Return the fastest change over `RATE_SPAN_S`, outliers left out [K/s]."""
    rates = []
    for run, values in zip(runs, readings, strict=True):
        there = np.isfinite(values)
        time = run.time_s[there]
        if len(time) < 2:
            continue
        if time[-1] - time[0] <= RATE_SPAN_S:
            rates.append(np.array([abs(values[there][-1] - values[there][0]) / RATE_SPAN_S]))
            continue
        start = np.arange(time[0], time[-1] - RATE_SPAN_S, RATE_SPAN_S / 5)
        change = np.interp(start + RATE_SPAN_S, time, values[there])
        rates.append(np.abs(change - np.interp(start, time, values[there])) / RATE_SPAN_S)
    return float(np.quantile(np.concatenate(rates), RATE_QUANTILE)) if rates else 0.0


def _largest_jump(readings: Sequence[Array]) -> float:
    """Return the largest change from one sample to the next, outliers left out [K]."""
    jumps = np.concatenate([np.abs(np.diff(values[np.isfinite(values)])) for values in readings])
    return float(np.quantile(jumps, RATE_QUANTILE)) if len(jumps) else 0.0


def _rounded(value: float) -> float:
    return float(f"{value:.6g}")
