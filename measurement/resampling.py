"""One signal from uneven samples onto other times, with gaps left open."""

from __future__ import annotations

from typing import TypeAlias

import numpy as np
import numpy.typing as npt

FloatArray: TypeAlias = npt.NDArray[np.float64]

GAP_INTERVALS = 5.0
"""Gaps of more than this many median intervals are not bridged by default. Set on loggers that
were watched: they drop a sample or three at a time (the longest pause of a good run was 3.2
intervals)."""
FINEST_K = 0.1
"""No thermometer is read, or told apart from another, more finely [K]: a usual resolution, set on
no data."""
WARMS_K = 2.0
"""A machine warms if its temperatures change by so much against each other or with time [K]. Set on
measured runs: in a good record with steps of 0.25 um the growth stood still for up to 107 min while
temperatures moved by at most 0.9 K; while known frozen channels stood still they moved by 3 K and
more."""
LAG_S = 1800.0
"""Longer than any lag between neighbouring thermometers, shorter than a run [s]: set on no data."""
WRONG = 0.01
"""So often is a log wrong in one of the usual ways, a unit, a place, a seam, and so often may
chance alone be told for something, as in `monitor` [1]: a judgement, set on no data;
docs/results.md reports how often that is right."""


def resample(
    time_s: FloatArray,
    values: FloatArray,
    grid_s: FloatArray,
    step_s: float,
    *,
    holds: bool = False,
    max_gap_s: float | None = None,
) -> FloatArray:
    """Return a signal at the grid's times.

    With ``holds`` the last valid sample holds. Otherwise, where two or more valid samples lie
    within half a step of a grid time, the linear interpolant's mean over that step is taken
    (exact for a straight line, whatever the spacing of the samples), and elsewhere its value.

    Parameters
    ----------
    time_s : array, shape (samples,)
        Times of the samples, growing [s].
    values : array, shape (samples,)
        The samples; NaN where missing.
    grid_s : array, shape (n,)
        The times wanted [s].
    step_s : float
        Over how long to average [s].
    holds : bool
        Whether the signal switches and then stays.
    max_gap_s : float, optional
        No value is given inside a gap between valid samples longer than this, nor later than this
        after the last sample of a signal that holds. Default: ``GAP_INTERVALS`` times the median
        interval of the valid samples, or ``step_s`` where that is longer [s].

    Returns
    -------
    array, shape (n,)
        NaN where the signal is not known.
    """
    valid = ~np.isnan(values)
    time, value = time_s[valid], values[valid]
    result = np.full(grid_s.shape, np.nan)
    if not time.size:
        return result
    if max_gap_s is None:
        interval = float(np.median(np.diff(time))) if time.size > 1 else 0.0
        max_gap_s = max(GAP_INTERVALS * interval, step_s)
    if holds:
        last = np.searchsorted(time, grid_s, side="right") - 1
        known = (last >= 0) & (grid_s - time[np.maximum(last, 0)] <= max_gap_s)
        result[known] = value[last[known]]
        return result
    cuts = np.flatnonzero(np.diff(time) > max_gap_s) + 1
    for part_time, part_value in zip(np.split(time, cuts), np.split(value, cuts), strict=True):
        inside = slice(*np.searchsorted(grid_s, [part_time[0], _after(part_time[-1])]))
        result[inside] = _of_part(part_time, part_value, grid_s[inside], step_s)
    return result


def _after(time: float) -> float:
    return float(np.nextafter(time, np.inf))


def _of_part(
    time: FloatArray, value: FloatArray, grid: FloatArray, step_s: float
) -> npt.NDArray[np.float64]:
    """Resample a part without gaps onto grid times that all lie within it."""
    at: FloatArray = np.interp(grid, time, value)
    # Shrunk towards the part's ends, so that the window stays centred on the grid time.
    half = np.minimum(step_s / 2.0, np.minimum(grid - time[0], time[-1] - grid))
    inside = np.searchsorted(time, grid + half) - np.searchsorted(time, grid - half, side="right")
    coarse = (inside >= 2) & (half > 0.0)
    if coarse.any():
        middle, width = grid[coarse], half[coarse]
        area = _area(time, value, middle + width) - _area(time, value, middle - width)
        at[coarse] = area / (2.0 * width)
    return at


def _area(time: FloatArray, value: FloatArray, until: FloatArray) -> FloatArray:
    """Return the integral of the linear interpolant from the first sample."""
    level = float(value[0])  # integrated apart, to keep the digits of a small drift
    pieces = np.diff(time) * (value[1:] + value[:-1] - 2.0 * level) / 2.0
    whole = np.concatenate([[0.0], np.cumsum(pieces)])
    last = np.clip(np.searchsorted(time, until, side="right") - 1, 0, time.size - 1)
    here = np.interp(until, time, value) - level
    part = (until - time[last]) * (value[last] - level + here) / 2.0
    area: FloatArray = whole[last] + part + level * (until - time[0])
    return area
