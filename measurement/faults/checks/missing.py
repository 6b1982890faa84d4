"""Channels with many missing samples."""

from __future__ import annotations

from collections.abc import Iterator
from typing import ClassVar

import numpy as np

from measurement.faults.checks.base import Check
from measurement.faults.fault import Fault, Kind
from measurement.faults.series import FEWEST_SAMPLES
from measurement.resampling import GAP_INTERVALS
from measurement.runs import Run

MISSING_SHARE = 0.01
"""A channel with a larger share of missing samples is named: below, averaging hides it well."""
SLOWER = 2.0
"""A channel whose readings come this many times more rarely than the rows is sampled slowly [1]."""


class Missing(Check):
    """Samples that are not there; a channel that is sampled slowly misses none."""

    kinds: ClassVar = {
        "missing": Kind("gaps of up to five usual intervals are bridged, longer ones left out")
    }
    stage = 0

    def in_run(self, run: Run) -> Iterator[Fault]:
        """Return the channels of a run that miss more than a few."""
        for name in map(str, run.frame.columns[1:]):
            missing = np.isnan(run.frame[name].to_numpy())
            share = float(missing.mean())
            if share <= MISSING_SHARE or _is_slow(run, ~missing):
                continue
            where = run.time_s[missing]
            text = f"{share:.1%} of the samples are missing"
            yield Fault(run.name, name, "missing", float(where[0]), float(where[-1]), text)


def _is_slow(run: Run, there: np.ndarray) -> bool:
    """Return whether readings come more rarely than rows, but regularly from start to end."""
    time = run.time_s
    if there.sum() < FEWEST_SAMPLES:
        return False
    intervals = np.diff(np.r_[time[0], time[there], time[-1]])
    usual = float(np.median(np.diff(time[there])))
    every = float(np.median(np.diff(time)))
    return bool(usual >= SLOWER * every and intervals.max() <= GAP_INTERVALS * usual)
