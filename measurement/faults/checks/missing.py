"""Channels with many missing samples."""

from __future__ import annotations

from collections.abc import Iterator
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from measurement.faults.checks.base import Check
from measurement.faults.fault import Fault, Kind
from measurement.faults.series import FEWEST_SAMPLES, IntArray
from measurement.resampling import GAP_INTERVALS
from measurement.runs import Run


class Missing(Check):
    """Missing samples, if the gap is too long to be bridged.

    Gaps are compared with the channel's own usual interval, so slow sampling is not a fault.
    """

    kinds: ClassVar = {
        "missing": Kind("gaps of up to five usual intervals are bridged, longer ones are left out")
    }
    stage = 0

    def in_run(self, run: Run) -> Iterator[Fault]:
        """Return the channels of a run with gaps that are not bridged."""
        for name in map(str, run.frame.columns[1:]):
            there = np.isfinite(run.frame[name].to_numpy())
            missing = np.zeros(0) if there.all() else _not_bridged(run, there)
            if missing.size:
                text = f"{missing.size / len(there):.1%} of the samples are missing"
                first, last = int(missing[0]), int(missing[-1])
                yield Fault.between(run, name, "missing", first, last, text)


def _not_bridged(run: Run, there: NDArray[np.bool_]) -> IntArray:
    """Return the rows without a reading in gaps that are too long to be bridged."""
    missing, time = np.flatnonzero(~there), run.time_s
    if there.sum() < FEWEST_SAMPLES:
        return missing
    # In a pause of the record, which `pauses` reports, no channel lacks a reading.
    steps = np.diff(time)
    usual = np.median(steps)
    time = time - np.r_[0.0, np.cumsum(np.where(steps > GAP_INTERVALS * usual, steps - usual, 0.0))]
    # From reading to reading, including the run's ends.
    rows = np.unique(np.r_[0, np.flatnonzero(there), len(time) - 1])
    open_ = np.diff(time[rows]) > GAP_INTERVALS * np.median(np.diff(time[there]))
    before = np.searchsorted(rows, missing, side="right") - 1
    return np.asarray(missing[open_[np.minimum(before, len(open_) - 1)]])
