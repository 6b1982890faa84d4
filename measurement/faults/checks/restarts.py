"""Displacements that return far from where they froze: they moved unseen."""

from __future__ import annotations

from collections.abc import Iterator
from typing import ClassVar

import numpy as np

from measurement.faults.checks.base import Check, Seen
from measurement.faults.checks.standing import MOVING_UM
from measurement.faults.fault import Fault, Kind
from measurement.faults.series import lengths_of


class Restarts(Check):
    """Uses the readings as read, because it needs the value at which the channel froze."""

    kinds: ClassVar = {"restart": Kind("kept: the reading is right again after it")}

    def find(self, seen: Seen) -> Iterator[Fault]:
        """Return the displacements that jump on their return."""
        for fault in seen.faults:
            run = seen.runs[fault.place]
            if fault.kind != "frozen" or fault.column not in lengths_of(run):
                continue
            values = run.frame[fault.column].to_numpy()
            after = np.flatnonzero((run.time_s > fault.end_s) & np.isfinite(values))
            if after.size < 3:
                continue
            # A few samples later, because the reading may take one or two to return.
            step = np.median(values[after[:5]]) - values[run.time_s >= fault.start_s][0]
            if abs(step) >= MOVING_UM:
                text = f"jumps by {step:+.0f} um on coming back"
                at = int(after[0])
                yield Fault.between(run, fault.column, "restart", at, at, text, fault.place)
