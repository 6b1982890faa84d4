"""Thermometers that leave all others within half an hour, ever faster, with nothing switched."""

from __future__ import annotations

from collections.abc import Iterator
from typing import ClassVar

import numpy as np
from scipy.ndimage import median_filter

from measurement.faults.checks.base import Check
from measurement.faults.fault import LEFT_OUT, Fault
from measurement.faults.series import FAR_K, FEWEST_SAMPLES, LASTS
from measurement.faults.switches import near_switch
from measurement.resampling import LAG_S
from measurement.runs import FloatArray, Run


class Runaways(Check):
    """Heat comes with a switch and also warms the neighbours; a broken sensor moves alone."""

    kinds: ClassVar = {"runaway": LEFT_OUT}
    stage = 2

    def in_run(self, run: Run) -> Iterator[Fault]:
        """Return the thermometers of a run that leave all others."""
        names, time = run.temperatures, run.time_s
        if len(names) < 3 or len(time) < 2 * FEWEST_SAMPLES:
            return
        table = run.frame[names].interpolate(limit_direction="both").to_numpy()
        known = np.flatnonzero(np.isfinite(table).all(axis=0)).tolist()
        moving = np.r_[0, np.cumsum(near_switch(run, after_s=LAG_S))]
        back = np.searchsorted(time, time - LAG_S)
        quiet = moving[1:] == moving[back]
        for place in known if len(known) >= 3 else []:
            others = table[:, [other for other in known if other != place]]
            away = median_filter(table[:, place] - np.median(others, axis=1), 5, mode="nearest")
            moved = away - away[back]
            # What an earlier switch has begun slows down.
            speeds_up = np.abs(moved) > moved[back] * np.sign(moved)
            gone = np.flatnonzero(quiet & speeds_up & (np.abs(moved) >= FAR_K))
            gone = gone[[_alone(others, int(back[i]), int(i), moved[i]) for i in gone.tolist()]]
            if not gone.size:
                continue
            i, first = int(gone[0]), int(back[gone[0]])
            level, way = float(away[first]), float(away[i] - away[first])
            off = np.flatnonzero((away - level) / way > LASTS)
            begun, last = int(off[off > first][0]), int(off[-1])
            end = float(np.median(away[i : last + 1])) - level
            text = (
                f"runs away from all other thermometers by {end:+.0f} K, with no switch of the "
                "machine near and no other that follows"
            )
            yield Fault.between(run, names[place], "runaway", begun, last, text)


def _alone(others: FloatArray, first: int, last: int, way: float) -> bool:
    """Return whether no other thermometer moved with it."""
    change = (others[last] - others[first]) * np.sign(way)
    return bool(np.max(change) < LASTS * abs(way))
