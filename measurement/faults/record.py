"""What befell a record as a whole: pauses, seams, missing samples."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from measurement.faults.fault import Fault
from measurement.faults.series import FEWEST_SAMPLES
from measurement.resampling import GAP_INTERVALS
from measurement.runs import TIME, FloatArray, Run

MISSING_SHARE = 0.01
"""A channel with a larger share of missing samples is named: below, averaging hides it well."""
SLOWER = 2.0
"""A channel whose readings come this many times more rarely than the rows is sampled slowly [1]."""
BESIDE = 3
"""So many steps on each side of one say how far a thermometer moves from row to row [1]."""
FINEST_K = 0.1
"""No thermometer is read more finely [K]."""
SEAM_ODDS = 0.01
"""So often is a record joined of two [1]: a judgement."""


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
    """Find where two recordings were joined: half of the thermometers leap at once.

    In one record, a step is as large as the largest of those beside it that go the same way, even
    where the machine is switched and samples are far apart; at a seam it is as large as what the
    thermometer does in the whole record. Both are taken as Laplace's, and the second must be
    likelier by the odds that any one of the rows is a seam.
    """
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
    leaps = told > np.log(len(steps) / SEAM_ODDS)
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
