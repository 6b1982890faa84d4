"""How well the truth itself does when it is told no more than the file of a run tells.

It knows its own cells, laws and numbers, so no description of the machine can be expected to leave
less. It does not know what nobody records: drafts, the air at the column, how friction wobbles, and
how warm column and bed are at first, which no thermometer reads. These start where they would stand
at rest, as a page has it.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pandas as pd

from benchmarks.gap.case import Bench, CaseRun, Shop, TruthCase
from benchmarks.gap.drive import REST, Array, Drive

UNREAD = ("column", "bed")
REST_HOURS = 160.0
"""How long column and bed are held at rest beside the parts that are read."""
STRIDE_H, STEP_S = 2.0, 600.0


def as_told(shop: Shop, case: TruthCase, run: CaseRun) -> pd.DataFrame:
    """Return what a case's machine would have done in a run had all gone as its file says.

    Parameters
    ----------
    shop : Shop
        Whose case it is.
    case : TruthCase
        With nothing hidden.
    run : CaseRun
        Of that case.

    Returns
    -------
    DataFrame
        Like ``run.frame``; thermometers and probes as they would be.
    """
    bench, drive = Bench(case, shop), run.drive
    march = bench.march
    outside = drive.outside.copy()
    for column, name in ((0, "T5_degC"), (1, "T5_degC"), (2, "T9_degC")):
        outside[:, column] = np.interp(drive.grid_s, drive.time_s, run.frame[name])
    outside[:, 3:] = 0.0
    usual = replace(drive, outside=outside, friction_factor=1.0, drive_factor=1.0)
    temperatures = march.run(usual, _rested(bench, drive, outside))
    spindle = march.machine
    pose = (temperatures - temperatures[0]) @ spindle.pose_weights
    return run.frame.assign(**spindle.readings(temperatures, pose))


def _rested(bench: Bench, drive: Drive, outside: Array) -> Array:
    """Return the true start, but column and bed where they would stand had it been so for long."""
    march, start = bench.march, bench.start_of(drive)
    unread = np.concatenate([march.machine.parts[part] for part in UNREAD])
    first = outside[np.searchsorted(drive.grid_s, drive.time_s[0])]
    held = np.tile(first, (len(drive.grid_s), 1))
    ends, zero = np.array([0.0, 3600.0 * STRIDE_H]), np.zeros(2)
    still = Drive(REST, ends, zero, zero, zero, drive.grid_s, held)
    now = start.copy()
    for _ in range(round(REST_HOURS / STRIDE_H)):
        settled = march.settle(still, now, STEP_S)
        now[unread] = settled[unread]
    return now
