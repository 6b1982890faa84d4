"""Resamples one signal from uneven samples to other times, leaving gaps open."""

from __future__ import annotations

from typing import Any, TypeAlias, TypeVar

import numpy as np
import numpy.typing as npt

FloatArray: TypeAlias = npt.NDArray[np.float64]
TimeT = TypeVar("TimeT", float, npt.NDArray[np.floating[Any]])

GAP_INTERVALS = 5.0
"""Gaps of more than this many median intervals are not bridged. Set on observed loggers,
which drop one to three samples at a time (the longest pause of a good run was 3.2 intervals)."""
FINEST_K = 0.1
"""Finest difference at which thermometers are read or distinguished [K]: a usual resolution, set on
no data."""
WARMS_K = 2.0
"""A machine warms if its temperatures change by this much relative to each other or with time [K].
Set on measured runs: in a good record with steps of 0.25 um the growth stood still for up to
107 min while temperatures moved by at most 0.9 K; during known freezes they moved by 3 K or
more."""
LAG_S = 1800.0
"""Longer than any lag between neighbouring thermometers, shorter than a run [s]: set on no data."""
SLOW_S = 300.0
"""Temperature and drift change slowly: only over longer times do they move more than noise and
resolution [s]. Rows closer than this say nothing more, nor does a probe so soon after the last one;
what a switch makes leap is over by then. Set on the planted faults."""
WRONG = 0.01
"""Share of logs that are wrong in one of the usual ways (a unit, a place, a seam), and share of
false alarms by chance alone, as in `monitor` [1]: a judgement, set on no data; docs/results.md
reports how often the alarms are right."""


def resample(
    time_s: FloatArray,
    values: FloatArray,
    grid_s: FloatArray,
    step_s: float,
    *,
    holds: bool = False,
) -> FloatArray:
    """Return a signal at the grid's times.

    With ``holds`` the last valid sample holds. Otherwise the samples are interpolated linearly: a
    grid time with two or more valid samples within half a step gets the interpolant's mean over
    that step (exact for a straight line with any sample spacing), others its value. There is no
    value in a gap of more than ``GAP_INTERVALS`` times the median interval of the valid samples, or
    ``step_s`` if that is longer, nor later than this after the last sample of a signal that holds.

    Parameters
    ----------
    time_s : array, shape (samples,)
        Times of the samples, increasing [s].
    values : array, shape (samples,)
        The samples; NaN if missing.
    grid_s : array, shape (n,)
        Times to resample to [s].
    step_s : float
        Averaging time [s].
    holds : bool
        Whether the signal switches and then stays.

    Returns
    -------
    array, shape (n,)
        NaN where the signal is unknown.
    """
    valid = ~np.isnan(values)
    time, value = time_s[valid], values[valid]
    result = np.full(grid_s.shape, np.nan)
    if not time.size:
        return result
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


def recorded_steps(time_s: FloatArray) -> FloatArray:
    """Return the time from each row to the next, a pause being at most `GAP_INTERVALS` usual steps.

    Parameters
    ----------
    time_s : array, shape (n,)
        Increasing [s].

    Returns
    -------
    array, shape (n - 1,)
        [s].
    """
    steps = np.diff(time_s)
    return np.minimum(steps, GAP_INTERVALS * np.median(steps)) if steps.size else steps


def past_rounding(time_s: TimeT) -> TimeT:
    """Return times later by more than their rounding error, for a comparison with a moment.

    A communication point is a number of steps times a step, which may be a little less than the
    same moment written in a scenario: 36 x 0.3 s is less than 10.8 s. A row of a run at 3660.7 s is
    less than an hour after one at 60.7 s.

    Parameters
    ----------
    time_s : float or array
        [s].
    """
    return time_s + 1e-12 * abs(time_s)


def _after(time: float) -> float:
    return float(np.nextafter(time, np.inf))


def _of_part(
    time: FloatArray, value: FloatArray, grid: FloatArray, step_s: float
) -> npt.NDArray[np.float64]:
    """Resample a part without gaps to grid times that all lie within it."""
    at: FloatArray = np.interp(grid, time, value)
    # Shrink the window near the part's ends, so that it stays centred on the grid time.
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
    level = float(value[0])  # integrated separately, to keep the digits of a small drift
    pieces = np.diff(time) * (value[1:] + value[:-1] - 2.0 * level) / 2.0
    whole = np.concatenate([[0.0], np.cumsum(pieces)])
    last = np.clip(np.searchsorted(time, until, side="right") - 1, 0, time.size - 1)
    here = np.interp(until, time, value) - level
    part = (until - time[last]) * (value[last] - level + here) / 2.0
    area: FloatArray = whole[last] + part + level * (until - time[0])
    return area
