"""Thermometers whose level is wrong, which shows only against other runs or other sensors."""

from __future__ import annotations

import warnings
from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from measurement.runs import FloatArray, Run
from measurement.units import split_column

LEVEL_JUMP_K = 10.0
"""A sensor whose level, against the middle of all others, moves by this much from one run to the
next has jumped [K]. Different work warms sensors differently, but by less than this."""
NEVER_RIGHT_K = 20.0
"""A sensor that is this far from the middle of all others when each run starts [K], and stays there
whatever the machine does, was never right."""
STAYS_SHARE = 0.3
"""It stays if its distance changes within a run by less than this share [1]."""
STRAY_K = 10.0
"""A sensor leaves the others within a run if it goes this far from their middle [K], and ..."""
STRAY_FACTOR = 3.0
"""... this many times further than in its other runs [1]."""

Wrong = tuple[str, str, list[str], str]
"""Kind, column, names of the runs, and what to say of it."""


def wrong_levels(runs: Sequence[Run]) -> list[Wrong]:
    """Return sensors whose level jumps between runs, or was never right.

    Parameters
    ----------
    runs : sequence of Run
        In the order in which they were recorded.

    Returns
    -------
    list of Wrong
        Of the kinds ``level_jump`` and ``never_right``.
    """
    return [*_level_jumps(runs), *_never_right(runs)]


def listed(names: Sequence[str]) -> str:
    """Return names of runs for a text; of many only the first and the last."""
    names = list(dict.fromkeys(names))
    return (
        ", ".join(names) if len(names) <= 3 else f"{len(names)} runs ({names[0]} ... {names[-1]})"
    )


def _against_others(runs: Sequence[Run], columns: Sequence[str]) -> FloatArray:
    """Return each sensor's median reading less the middle of the others', (runs, columns) [K]."""
    level = np.array([[_median(run.frame[name].to_numpy()) for name in columns] for run in runs])
    others = [_middle(np.delete(level, place, axis=1)) for place in range(len(columns))]
    return np.asarray(level - np.column_stack(others))


def _middle(levels: FloatArray) -> FloatArray:
    """Return the median of each row; NaN where a row has no value."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)  # A row without a value has no median.
        return np.asarray(np.nanmedian(np.where(np.isfinite(levels), levels, np.nan), axis=1))


def _median(values: FloatArray) -> float:
    values = values[np.isfinite(values)]
    return float(np.median(values)) if values.size else float("nan")


def _shared(runs: Sequence[Run]) -> list[str]:
    return [name for name in runs[0].temperatures if all(name in run.frame for run in runs)]


def _level_jumps(runs: Sequence[Run]) -> list[Wrong]:
    """Return sensors whose level changes for good, or for some runs, as no other's does."""
    columns = _shared(runs)
    if len(runs) < 3 or len(columns) < 3:
        return []
    away = _against_others(runs, columns)
    found = []
    for place, name in enumerate(columns):
        series = away[:, place]
        if not np.isfinite(series).all():
            continue
        ranked = np.sort(series)
        gaps = np.diff(ranked)
        at = int(np.argmax(gaps))
        apart = ranked <= ranked[at], ranked > ranked[at]
        if gaps[at] < LEVEL_JUMP_K or max(np.ptp(ranked[side]) for side in apart) > gaps[at]:
            continue
        # The level that is nearer to all other sensors' is the right one.
        low, high = (float(np.median(ranked[side])) for side in apart)
        off = high - low if abs(high) >= abs(low) else low - high
        wrong = series > ranked[at] if off > 0.0 else series <= ranked[at]
        found.append(_wrong_in(name, off, wrong, runs))
    return found


def _wrong_in(name: str, off: float, wrong: npt.NDArray[np.bool_], runs: Sequence[Run]) -> Wrong:
    """Return the fault of a sensor whose level is off by so much [K] in some runs."""
    names = [run.name for run, bad in zip(runs, wrong, strict=True) if bad]
    if wrong[-1] and wrong[-len(names) :].all():
        when = f"from {names[0]} on"
    elif wrong[: len(names)].all():
        when = f"until {names[-1]}"
    else:
        when = f"in {listed(names)}"
    high = "high" if off > 0.0 else "low"
    text = f"{name}: {split_column(name)[0]} reads {abs(off):.0f} K {high} {when}"
    return "level_jump", name, names, text


def _never_right(runs: Sequence[Run]) -> list[Wrong]:
    """Return sensors that are far from all others in every run, from its start to its end."""
    columns = _shared(runs)
    if len(columns) < 4:
        return []
    found = []
    tables = [run.frame[columns].interpolate(limit_direction="both").to_numpy() for run in runs]
    for place, name in enumerate(columns):
        apart = [table[:, place] - _middle(np.delete(table, place, axis=1)) for table in tables]
        least = [float(np.min(np.abs(away))) for away in apart]
        stays = all(
            np.ptp(away) < STAYS_SHARE * abs(np.median(away)) and np.all(away * away[0] > 0.0)
            for away in apart
        )
        if min(least) >= NEVER_RIGHT_K and stays:
            off = float(np.median([np.median(away) for away in apart]))
            names = [run.name for run in runs]
            text = f"{name}: {split_column(name)[0]} is {off:+.0f} K from all others in every run"
            found.append(("never_right", name, names, text))
    return found


def strays(runs: Sequence[Run]) -> list[tuple[str, list[str], str]]:
    """Return sensors that leave all others within one run: column, run, text."""
    columns = _shared(runs)
    if len(runs) < 2 or len(columns) < 3:
        return []
    furthest = np.zeros((len(runs), len(columns)))
    for row, run in enumerate(runs):
        rises = run.frame[columns].bfill().to_numpy()
        rises = rises - rises[0]
        away = rises - np.nanmedian(rises, axis=1, keepdims=True)
        place = np.nanargmax(np.abs(np.nan_to_num(away)), axis=0)
        furthest[row] = away[place, np.arange(len(columns))]
    found = []
    size = np.abs(furthest)
    for place, name in enumerate(columns):
        worst = int(np.argmax(size[:, place]))
        run = runs[worst]
        others = np.delete(size[:, place], worst).max()
        if size[worst, place] >= max(STRAY_K, STRAY_FACTOR * others):
            off = furthest[worst, place]
            text = f"{name}: within {run.name} it leaves all others by {off:+.0f} K"
            found.append((name, [run.name], text))
    return found
