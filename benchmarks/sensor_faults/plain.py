"""What a plain rule finds: the baseline beside the detector.

Constant for a quarter of an hour; a leap between two samples; far from the middle of all others.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from measurement.faults import Fault
from measurement.faults.series import lengths_of, unchanged_for, valid
from measurement.runs import Run

CONSTANT_S = 900.0
LEAP = {"degC": 4.0, "um": 20.0}
AWAY_K = 20.0


def plain_faults(runs: Sequence[Run]) -> list[Fault]:
    """Return what the plain rule calls broken."""
    found = []
    for place, run in enumerate(runs):
        end = float(run.time_s[-1])
        middle = run.frame[run.temperatures].median(axis=1).to_numpy()
        for column in [*run.temperatures, *lengths_of(run)]:
            rows, values = valid(run, column)
            if len(values) < 3:
                continue
            time = run.time_s[rows]
            age = unchanged_for(time, values)
            if age.max() > CONSTANT_S:
                last = int(np.argmax(age))
                start, stop = float(time[last] - age[last]), float(time[last])
                found.append(Fault(run.name, column, "frozen", start, stop, "constant", place))
            leap = np.flatnonzero(np.abs(np.diff(values)) > LEAP[column.rpartition("_")[2]])
            if leap.size:
                start = float(time[leap[0] + (leap[0] > 0)])
                stop = start if leap.size > 1 or leap[0] == 0 else end
                if leap[0] == 0:
                    start = stop = float(time[0])
                found.append(Fault(run.name, column, "step", start, stop, "leap", place))
            if column in run.temperatures:
                away = np.abs(values - middle[rows])
                if np.median(away) > AWAY_K:
                    first = float(time[0])
                    found.append(Fault(run.name, column, "never_right", first, end, "far", place))
    return found
