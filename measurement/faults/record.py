"""What befell a record as a whole: pauses, seams, missing samples."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from measurement.faults.fault import Fault
from measurement.faults.series import FEWEST_SAMPLES
from measurement.faults.switches import near_switch
from measurement.resampling import GAP_INTERVALS
from measurement.runs import TIME, Run

MISSING_SHARE = 0.01
"""A channel with a larger share of missing samples is named: below, averaging hides it well."""
SLOWER = 2.0
"""A channel whose readings come this many times more rarely than the rows is sampled slowly [1]."""
JUMP_K = 2.0
"""Half of all temperatures moving by more than this from one sample to the next is no heat flow
[K]: two recordings were joined, or the logger restarted. The largest step of the middle sensor is
0.1 K in 30 good records, and 4.3 K in one that shows such a seam."""


def record(run: Run) -> list[Fault]:
    """Return what befell the record of a run."""
    found = [*_pauses(run), *_seams(run)]
    for name in map(str, run.frame.columns[1:]):
        found += _missing(run, name)
    return found


def _pauses(run: Run) -> Iterator[Fault]:
    steps = np.diff(run.time_s)
    if steps.size < FEWEST_SAMPLES:
        return
    usual = float(np.median(steps))
    long = np.flatnonzero(steps > GAP_INTERVALS * usual)
    if long.size:
        at = long[np.argmax(steps[long])]
        start, end = float(run.time_s[at]), float(run.time_s[at + 1])
        text = (
            f"{long.size} {'pause' if long.size == 1 else 'pauses'} of more than "
            f"{GAP_INTERVALS:g} usual intervals ({usual:g} s) in the record, the longest of "
            f"{(end - start) / 60:.1f} min"
        )
        yield Fault(run.name, TIME, "pause", start, end, text)


def _seams(run: Run) -> Iterator[Fault]:
    """Find where half of the thermometers jump at once; what was joined on is another recording."""
    if len(run.temperatures) < 2 or len(run.frame) < 2:
        return
    steps = np.abs(np.diff(run.frame[run.temperatures].to_numpy(), axis=0))
    # A missing neighbour is not a jump, and over a pause heat has time to flow. With samples far
    # apart, a switch makes half of all thermometers jump too.
    jumped = (np.nan_to_num(steps) > JUMP_K).sum(axis=1) >= len(run.temperatures) / 2
    time_steps = np.diff(run.time_s)
    jumped &= time_steps <= GAP_INTERVALS * np.median(time_steps)
    jumped &= ~near_switch(run)[1:]
    if jumped.any():
        at = int(np.argmax(jumped))
        text = (
            f"half of the temperatures or more jump by over {JUMP_K:g} K between two samples: "
            "joined recordings, or the logger restarted"
        )
        start, end = float(run.time_s[at + 1]), float(run.time_s[-1])
        yield Fault(run.name, TIME, "jump", start, end, text)


def _missing(run: Run, name: str) -> Iterator[Fault]:
    missing = np.isnan(run.frame[name].to_numpy())
    share = float(missing.mean())
    if share <= MISSING_SHARE or _is_slow(run, ~missing):
        return
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
