"""Thermometers that are far from all others from the first sample on.

A hot bearing is also far from the other thermometers, but because of heat: it began near them, or
the others are spread as well; its neighbours warm with it, and it follows the load. A broken sensor
is off while all others are close together, whatever the machine does.
"""

from __future__ import annotations

import warnings
from collections.abc import Iterator, Sequence
from typing import ClassVar

import numpy as np
import numpy.typing as npt

from measurement.faults.checks.base import Check, Seen
from measurement.faults.fault import WRONG_LEVEL, Fault
from measurement.faults.series import FAR_K, FEWEST_SAMPLES, UNUSUALLY
from measurement.runs import Run


class Levels(Check):
    """Thermometers whose level is wrong in some runs or in all, each over a whole run."""

    kinds: ClassVar = {"level_jump": WRONG_LEVEL, "never_right": WRONG_LEVEL}

    def find(self, seen: Seen) -> Iterator[Fault]:
        """Return the thermometers that are far from the others without a cause."""
        runs = seen.left
        first = runs[0].temperatures if runs else []
        columns = [name for name in first if all(name in run.frame for run in runs)]
        tables = [_Distances(run, columns) for run in runs]
        faults: dict[tuple[int, str], Fault] = {}
        for column, name in enumerate(columns):
            for place, off in _level_jumps(tables, column):
                text = f"reads {off:+.0f} K compared with its level in the other runs"
                fault = Fault.between(runs[place], name, "level_jump", 0, -1, text, place)
                faults[place, name] = fault
        for place, run in enumerate(runs):
            known = columns == run.temperatures
            own = tables[place] if known else _Distances(run, run.temperatures)
            for column, name in enumerate(run.temperatures):
                off = own.never_right(column)
                if off and (place, name) not in faults:
                    text = f"reads {off:+.0f} K compared with all others, whatever the machine does"
                    fault = Fault.between(run, name, "never_right", 0, -1, text, place)
                    faults[place, name] = fault
        yield from faults.values()


class _Distances:
    """Distance of each thermometer from the median of the others, over one run [K]."""

    def __init__(self, run: Run, columns: Sequence[str]) -> None:
        table = run.frame[list(columns)].interpolate(limit_area="inside").to_numpy()
        count = table.shape[1]
        self.away = np.full((count, len(table)), np.nan)
        self.spread = np.full(count, np.nan)
        self._range = np.full(count, np.nan)
        if count < 3 or not len(table):
            return
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", RuntimeWarning)  # A row without a value has no median.
            begin = np.nanmedian(table[:FEWEST_SAMPLES], axis=0)
            for place in range(count):
                others = np.delete(table, place, axis=1)
                # Much faster if nothing is missing.
                median = np.nanmedian if np.isnan(others).any() else np.median
                middle = median(others, axis=1)
                self.away[place] = table[:, place] - middle
                wide = 1.4826 * median(np.abs(others - middle[:, None]), axis=1)
                self.spread[place] = np.nanmedian(wide)
                low, high = np.nanpercentile(np.delete(begin, place), [5, 95])
                self._range[place] = high - low

    def range(self, column: int) -> tuple[float, float, float]:
        """Return the 5 %, 50 % and 95 % quantiles of a sensor's distance, its start included [K].

        A part that is hot for most of a run began near the others. NaN if there is no value.
        """
        away = self.away[column][np.isfinite(self.away[column])]
        if not away.size:
            return (float("nan"),) * 3
        low, middle, high = np.percentile(away, [5, 50, 95])
        start = float(np.median(away[:FEWEST_SAMPLES]))
        return min(float(low), start), float(middle), max(float(high), start)

    def never_right(self, column: int) -> float:
        """Return the distance of a sensor that is always far from all others, else 0 [K]."""
        away = self.away[column][np.isfinite(self.away[column])]
        if len(self.away) < 4 or away.size < FEWEST_SAMPLES:
            return 0.0
        limit = max(FAR_K, UNUSUALLY * float(self._range[column]))
        middle = float(np.median(away))
        least = float(np.min(away * np.sign(middle)))
        return middle if least >= limit else 0.0


def _level_jumps(tables: Sequence[_Distances], column: int) -> list[tuple[int, float]]:
    """Return the runs in which a sensor's level is wrong, and by how much [K]."""
    ranges = np.array([table.range(column) for table in tables]).reshape(-1, 3)
    have = np.flatnonzero(np.isfinite(ranges).all(axis=1))
    if len(have) < 3:
        return []
    low, middle, high = ranges[have].T
    ranked = np.sort(middle)
    gaps = np.diff(ranked)
    cut = float(ranked[int(np.argmax(gaps))])
    above: npt.NDArray[np.bool_] = middle > cut
    if not above.any():  # all equal to the last digit
        return []
    # Its distance from the others differs by at least this much at all times.
    between = float(low[above].min() - high[~above].max())
    if max(np.ptp(middle[above]), np.ptp(middle[~above])) > gaps.max():
        return []
    # The level nearer to those of all other sensors is the right one.
    off = float(np.median(middle[above]) - np.median(middle[~above]))
    wrong = above
    if abs(np.median(middle[above])) < abs(np.median(middle[~above])):
        off, wrong = -off, ~above
    spread = max(tables[place].spread[column] for place in have[wrong])
    if between < max(FAR_K, UNUSUALLY * float(spread)):
        return []
    return [(int(place), off) for place in have[wrong]]
