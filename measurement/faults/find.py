"""The detector: every check in the order in which one explains another away."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence
from dataclasses import replace

import numpy as np

from measurement.faults.fault import GROSS, Fault
from measurement.faults.leaps import leaps
from measurement.faults.levels import runaways, wrong_levels
from measurement.faults.record import record
from measurement.faults.series import lengths_of
from measurement.faults.standing import standing_displacements, standing_thermometers
from measurement.runs import TIME, FloatArray, Run

RESTART_UM = 3.0
"""A displacement that comes back from a standstill this far away has moved unseen [um]."""
COARSE_SHARE = 1 / 200
"""Readings whose smallest step is more than this share of their range are on a staircase [1]."""
STANDING_SHARE = 0.5
"""So are those that repeat the reading before in more than this share of samples [1]."""


def find_faults(runs: Sequence[Run]) -> list[Fault]:
    """Return what is wrong with runs, by run and time.

    Parameters
    ----------
    runs : sequence of Run
        All that belong together: some faults show only against other runs. A fault's place is that
        of its run among them. Runs that `looked_over` returned are not looked at again.
    """
    if all(run.faults is not None for run in runs):
        return [
            fault for place, run in enumerate(runs) for fault in _placed(place, run.faults or ())
        ]
    # What stood still catches up in a leap, and a leap looks like running away: each check sees
    # the readings that are left by the one before it.
    found = [fault for place, run in enumerate(runs) for fault in _placed(place, record(run))]
    still = list(standing_thermometers(runs))
    for place, run in enumerate(runs):
        still += _placed(place, standing_displacements(run))
    found += still
    left = cleaned(runs, found)
    seams = {(fault.place, fault.start_s) for fault in found if fault.kind == "jump"}
    for check in (leaps, runaways):
        more = [fault for place, run in enumerate(left) for fault in _placed(place, check(run))]
        more = [fault for fault in more if (fault.place, fault.start_s) not in seams]
        found += more
        left = cleaned(left, more)
    found += wrong_levels(left)
    for place, run in enumerate(runs):
        frozen = [fault for fault in still if fault.place == place and fault.kind == "frozen"]
        found += _placed(place, _restarts(run, frozen))
        found += _placed(place, _staircases(left[place]))
    return sorted(found, key=lambda fault: (fault.place, fault.start_s, fault.column))


def looked_over(runs: Sequence[Run]) -> list[Run]:
    """Return the runs with what `find_faults` finds in all of them together.

    Whatever part of them is looked at later, for a fold or for a figure, the verdict is the same.

    Parameters
    ----------
    runs : sequence of Run
        All that belong together, as `find_faults` takes them.
    """
    faults = find_faults(runs)
    return [
        replace(run, faults=tuple(fault for fault in faults if fault.place == place))
        for place, run in enumerate(runs)
    ]


def unusable(faults: Sequence[Fault], kinds: Collection[str] = GROSS) -> list[Fault]:
    """Return the faults whose time is not to be used, those inside others left out.

    Parameters
    ----------
    faults : sequence of Fault
    kinds : collection of str
        The kinds that count; by default those whose readings are not what the machine did.
    """
    widest = sorted(
        (fault for fault in faults if fault.kind in kinds),
        key=lambda fault: fault.start_s - fault.end_s,
    )
    kept: list[Fault] = []
    for fault in widest:
        inside = (
            wider
            for wider in kept
            if (wider.column, wider.place) == (fault.column, fault.place)
            and wider.start_s <= fault.start_s
            and fault.end_s <= wider.end_s
        )
        if next(inside, None) is None:
            kept.append(fault)
    return sorted(kept, key=lambda fault: (fault.place, fault.column, fault.start_s))


def cleaned(
    runs: Sequence[Run], faults: Sequence[Fault], kinds: Collection[str] = GROSS
) -> list[Run]:
    """Return the runs without the readings that are not to be used.

    Parameters
    ----------
    runs : sequence of Run
        Those that `find_faults` was given, in the same order.
    faults : sequence of Fault
        What it found.
    kinds : collection of str
        Faults of other kinds are passed over.

    Returns
    -------
    list of Run
        Readings taken out are NaN. The first reading of a run stays even if the channel is frozen
        from it on: it was true. After a
        seam all displacements go, for what they count from is another recording's.
    """
    result = list(runs)
    for place, run in enumerate(runs):
        here = [fault for fault in faults if fault.place == place and fault.kind in kinds]
        here = [fault for fault in here if fault.column == TIME or fault.column in run.frame]
        if not here:
            continue
        frame, time = run.frame.copy(), run.time_s
        for fault in here:
            rows = (time >= fault.start_s) & (time <= fault.end_s)
            if fault.kind in ("frozen", "saturated") and fault.start_s == time[0]:
                rows[0] = False
            names = lengths_of(run) if fault.column == TIME else [fault.column]
            frame.loc[rows, names] = np.nan
        result[place] = replace(run, frame=frame)
    return result


def _placed(place: int, faults: Sequence[Fault] | Iterator[Fault]) -> list[Fault]:
    return [replace(fault, place=place) for fault in faults]


def _restarts(run: Run, frozen: Sequence[Fault]) -> Iterator[Fault]:
    """Find displacements that come back far from where they froze."""
    for fault in frozen:
        if fault.column not in lengths_of(run):
            continue
        values = run.frame[fault.column].to_numpy()
        after = np.flatnonzero((run.time_s > fault.end_s) & np.isfinite(values))
        at = values[np.searchsorted(run.time_s, fault.start_s)]
        # A few samples on: the reading may take one or two to come back.
        if after.size >= 3 and abs(step := float(np.median(values[after[:5]]) - at)) > RESTART_UM:
            text = f"jumps by {step:+.0f} um on coming back"
            time = float(run.time_s[after[0]])
            yield Fault(run.name, fault.column, "restart", time, time, text)


def _staircases(run: Run) -> Iterator[Fault]:
    """Find displacements that are read in coarse steps, or stand still between them."""
    for name in lengths_of(run):
        values: FloatArray = run.frame[name].dropna().to_numpy()
        moves = np.abs(np.diff(values))
        if not (moves > 0).any():
            continue
        still = float((moves == 0).mean())
        usual = float(np.median(moves[moves > 0]))
        if usual > COARSE_SHARE * float(np.ptp(values)) and still > STANDING_SHARE:
            text = f"a staircase with steps of {usual:.2g} um, unchanged in {still:.0%} of samples"
            start, end = float(run.time_s[0]), float(run.time_s[-1])
            yield Fault(run.name, name, "staircase", start, end, text)
