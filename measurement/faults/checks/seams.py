"""Records that were joined of two: half of the thermometers leap at once."""

from __future__ import annotations

from collections.abc import Iterator
from typing import ClassVar

import numpy as np

from measurement.faults.checks.base import Check
from measurement.faults.fault import Fault, Kind
from measurement.resampling import FINEST_K, GAP_INTERVALS, WRONG
from measurement.runs import TIME, FloatArray, Run

BESIDE = 3
"""So many steps on each side of one say how far a thermometer moves from row to row [1]. Set on the
planted faults."""


class Seams(Check):
    """A leap too large for one record.

    In one record, a step is as large as the largest of those beside it that go the same way, even
    where the machine is switched and samples are far apart; at a seam it is as large as what the
    thermometer does in the whole record. Both are taken as Laplace's, and the second must be
    likelier by the odds that any one of the rows is a seam.
    """

    kinds: ClassVar = {"jump": Kind("the record is used up to there", "none")}
    stage = 0

    def in_run(self, run: Run) -> Iterator[Fault]:
        """Return the first row of the second recording, if there is one."""
        names = run.temperatures
        signed = np.diff(run.frame[names].to_numpy(), axis=0)
        steps = np.abs(signed)
        if len(names) < 2 or len(steps) <= 2 * BESIDE:
            return
        up, down = _largest_beside(signed), _largest_beside(-signed)
        usual = np.fmax(np.where(signed > 0.0, up, down), FINEST_K)
        read = run.frame[names].to_numpy()
        whole = np.fmax(np.fmax.reduce(read) - np.fmin.reduce(read), usual)
        gain = np.log(usual / whole) + steps / usual - steps / whole
        # A missing neighbour is no witness, and over a pause heat has time to flow.
        gain = np.nan_to_num(gain, nan=-np.inf)
        needed = max(len(names) // 2, 2)  # a single one that leaps is that one's matter
        told = np.sort(gain, axis=1)[:, -needed]
        time_steps = np.diff(run.time_s)
        leaps = told > np.log(len(steps) / WRONG)
        leaps &= time_steps <= GAP_INTERVALS * np.median(time_steps)
        if leaps.any():
            at = int(np.argmax(leaps))
            text = (
                f"half of the temperatures or more leap at once, by up to {steps[at].max():.1f} K: "
                "joined recordings, or the logger restarted"
            )
            start, end = float(run.time_s[at + 1]), float(run.time_s[-1])
            yield Fault(run.name, TIME, "jump", start, end, text)


def _largest_beside(steps: FloatArray) -> FloatArray:
    """Return for each step the largest of those beside it; 0 where none is more than that."""
    padded = np.pad(np.nan_to_num(steps), ((BESIDE, BESIDE), (0, 0)))
    shifts = [n for n in range(2 * BESIDE + 1) if n != BESIDE]
    return np.asarray(np.max([padded[n : n + len(steps)] for n in shifts], axis=0))
