"""The detector: every check, stage by stage, each on what the stages before it left."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import replace
from itertools import groupby

import numpy as np

from measurement.faults.checks import checks
from measurement.faults.checks.base import Seen
from measurement.faults.fault import STANDING, Fault
from measurement.faults.kinds import GROSS
from measurement.faults.series import lengths_of
from measurement.runs import TIME, Run


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
            replace(fault, place=place)
            for place, run in enumerate(runs)
            for fault in run.faults or ()
        ]
    faults: list[Fault] = []
    left = list(runs)
    for _, stage in groupby(checks(), key=lambda check: check.stage):
        seen = Seen(runs, left, faults)
        faults = [*faults, *(fault for check in stage for fault in check.find(seen))]
        # That a thermometer leaps where another recording was joined on is explained by that.
        seams = {(fault.place, fault.start_s) for fault in faults if fault.kind == "jump"}
        faults = [
            fault
            for fault in faults
            if not (fault.column.endswith("_degC") and (fault.place, fault.start_s) in seams)
        ]
        left = cleaned(runs, faults)
    return sorted(faults, key=lambda fault: (fault.place, fault.start_s, fault.column))


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
            if fault.kind in STANDING and fault.start_s == time[0]:
                rows[0] = False
            names = lengths_of(run) if fault.column == TIME else [fault.column]
            frame.loc[rows, names] = np.nan
        result[place] = replace(run, frame=frame)
    return result
