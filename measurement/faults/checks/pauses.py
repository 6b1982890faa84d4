"""Pauses in a record."""

from __future__ import annotations

from collections.abc import Iterator
from typing import ClassVar

import numpy as np

from measurement.errors import counted
from measurement.faults.checks.base import Check
from measurement.faults.fault import Fault, Kind
from measurement.faults.series import FEWEST_SAMPLES
from measurement.resampling import GAP_INTERVALS
from measurement.runs import TIME, Run


class Pauses(Check):
    """Rows that are much further apart than usual."""

    kinds: ClassVar = {"pause": Kind("kept: models go by time, not by rows")}
    stage = 0

    def in_run(self, run: Run) -> Iterator[Fault]:
        """Return the longest pause of a run, and how many there are."""
        steps = np.diff(run.time_s)
        if steps.size < FEWEST_SAMPLES:
            return
        usual = float(np.median(steps))
        long = np.flatnonzero(steps > GAP_INTERVALS * usual)
        if long.size:
            at = int(long[np.argmax(steps[long])])
            text = (
                f"{counted(long.size, 'pause')} of more than "
                f"{GAP_INTERVALS:g} usual intervals ({usual:g} s) in the record, the longest of "
                f"{steps[at] / 60:.1f} min"
            )
            yield Fault.between(run, TIME, "pause", at, at + 1, text)
