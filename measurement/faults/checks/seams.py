"""Records joined from two recordings: half of the thermometers leap at once."""

from __future__ import annotations

from collections.abc import Iterator
from typing import ClassVar

import numpy as np

from measurement.faults.checks.base import Check
from measurement.faults.fault import Fault, Kind
from measurement.faults.leaping import BESIDE, moves_of
from measurement.runs import TIME, Run


class Seams(Check):
    """A leap that does not occur within one record.

    In one record half of the thermometers never leap together, even if the machine is switched and
    samples are far apart.
    """

    kinds: ClassVar = {"jump": Kind("the record is used up to there", "none")}
    stage = 0

    def in_run(self, run: Run) -> Iterator[Fault]:
        """Return the first row of the second recording, if there is one."""
        names = run.temperatures
        if len(names) < 2 or len(run.time_s) <= 2 * BESIDE:
            return
        odds = np.full((len(run.time_s) - 1, len(names)), -np.inf)
        for name, column in zip(names, odds.T, strict=True):
            moves = moves_of(run, name)
            # A missing neighbouring row proves nothing, and during a pause heat has time to flow.
            beside = np.diff(moves.rows) == 1
            column[moves.rows[:-1][beside]] = moves.odds[beside]
        needed = max(len(names) // 2, 2)  # a single thermometer that leaps is no seam
        leaps = np.sort(odds, axis=1)[:, -needed] > 0.0
        if leaps.any():
            at = int(np.argmax(leaps))
            most = np.nanmax(np.abs(np.diff(run.frame[names].to_numpy()[at : at + 2], axis=0)))
            text = (
                f"at least half of the temperatures leap at once, by up to {most:.1f} K: "
                "joined recordings, or the logger restarted"
            )
            yield Fault.between(run, TIME, "jump", at + 1, -1, text)
