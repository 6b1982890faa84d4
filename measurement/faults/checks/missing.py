"""Channels with many missing samples."""

from __future__ import annotations

from collections.abc import Iterator
from typing import ClassVar

import numpy as np

from measurement.faults.checks.base import Check
from measurement.faults.fault import Fault, Kind
from measurement.faults.series import FEWEST_SAMPLES
from measurement.resampling import GAP_INTERVALS, recorded_steps
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
            missing = np.isnan(run.frame[name].to_numpy())
            if not missing.any() or _are_bridged(run, ~missing):
                continue
            first, last = np.flatnonzero(missing)[[0, -1]].tolist()
            text = f"{missing.mean():.1%} of the samples are missing"
            yield Fault.between(run, name, "missing", first, last, text)


def _are_bridged(run: Run, there: np.ndarray) -> bool:
    """Return whether readings are close together wherever rows lack one."""
    if there.sum() < FEWEST_SAMPLES:
        return False
    time = np.append(0.0, np.cumsum(recorded_steps(run.time_s)))  # `pauses` checks for its pauses
    # From reading to reading, including the run's ends.
    rows = np.unique(np.r_[0, np.flatnonzero(there), len(time) - 1])
    gaps = np.diff(time[rows])[(np.diff(rows) > 1) | ~there[rows[:-1]] | ~there[rows[1:]]]
    return bool(gaps.max(initial=0.0) <= GAP_INTERVALS * np.median(np.diff(time[there])))
