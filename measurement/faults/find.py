"""The detector: runs every check, stage by stage, on what the previous stages left."""

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
    """Return the faults of runs, sorted by run and time.

    Parameters
    ----------
    runs : sequence of Run
        All runs that belong together, because some faults show only against other runs. A fault's
        place is the index of its run. Runs from `looked_over` are not checked again.
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
        # A leap of a thermometer at a seam is explained by the seam.
        seams = {(fault.place, fault.start_s) for fault in faults if fault.kind == "jump"}
        faults = [
            fault
            for fault in faults
            if not (fault.column.endswith("_degC") and (fault.place, fault.start_s) in seams)
        ]
        left = cleaned(runs, faults)
    return sorted(faults, key=lambda fault: (fault.place, fault.start_s, fault.column))


def looked_over(runs: Sequence[Run]) -> list[Run]:
    """Return the runs with the faults that `find_faults` finds in all of them together.

    Any part of them used later, in a fold or a figure, then has the same verdict.

    Parameters
    ----------
    runs : sequence of Run
        All runs that belong together, as for `find_faults`.
    """
    faults = find_faults(runs)
    return [
        replace(run, faults=tuple(fault for fault in faults if fault.place == place))
        for place, run in enumerate(runs)
    ]


def unusable(faults: Sequence[Fault], kinds: Collection[str] = GROSS) -> list[Fault]:
    """Return the faults whose span is unusable, except those inside others.

    Parameters
    ----------
    faults : sequence of Fault
    kinds : collection of str
        Kinds to include; by default those whose readings are not what the machine did.
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
    """Return the runs without the unusable readings.

    Parameters
    ----------
    runs : sequence of Run
        The runs passed to `find_faults`, in the same order.
    faults : sequence of Fault
        The faults found.
    kinds : collection of str
        Faults of other kinds are ignored.

    Returns
    -------
    list of Run
        Removed readings are NaN. The first reading of a run stays even if the channel is frozen
        from it on, because it was true. After a seam all displacements are removed, because they
        count from another recording's zero.
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
