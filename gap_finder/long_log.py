"""Splits one long recording into runs; each starts with the heat left by the one before.

A log of several days contains slow changes of hidden parts, and no sensor measures how warm they
are when a piece begins. So each piece is simulated with the recorded inputs from the beginning of
the log, but compared only from its own beginning.
"""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np

from gap_finder.observations import INDEPENDENT_S, Observations
from measurement.errors import BadInput
from measurement.importing.mapping import Mapping
from measurement.runs import TIME, Run
from plant_model.machine import Machine

_PIECE = "_{}of{}"


def need_no_leap(run: Run) -> None:
    """Refuse a run that is two: with a pause longer than all the rest, after which it began cold.

    A model is stepped through pauses, too, and takes hours for one of months.

    Raises
    ------
    BadInput
        For the longest pause.
    """
    time = run.time_s
    steps = np.diff(time, append=time[-1])
    at = int(np.argmax(steps))
    if steps[at] > max(time[-1] - time[0] - steps[at], Mapping().cold_after_s):
        problem = (
            f"{float(time[at + 1])!r} after {float(time[at])!r}, the previous row, is a pause "
            "longer than all the rest, and leaves the machine cold: cut the run in two there, as "
            "spindle-drift import does"
        )
        raise BadInput(run.path or run.name, f"column {TIME}", problem)


def pieces_of(machine: Machine, run: Run, hours: float) -> list[Run]:
    """Split a run into pieces of some hours; return the run itself if it is too short.

    Parameters
    ----------
    machine : Machine
        Its inputs are kept in every piece.
    run : Run
    hours : float
        Length of a piece [h].

    Returns
    -------
    list of Run
        Each with all rows, so that all are driven alike. Columns that are only compared are NaN
        outside the piece, except in the first row of the log, from which every part starts.
    """
    time = run.time_s
    starts = np.arange(time[0], time[-1], 3600.0 * hours)
    firsts = np.unique(np.searchsorted(time, starts - 1e-6))  # in a pause no piece begins
    # A last piece too short for one independent value is joined to the one before.
    firsts = np.concatenate([firsts[:1], firsts[1:][time[-1] - time[firsts[1:]] >= INDEPENDENT_S]])
    if len(firsts) < 2:
        return [run]
    driving = {TIME, *(entry.column for entry in machine.inputs)}
    compared = [name for name in run.frame.columns if name not in driving]
    at_start = run.frame[compared].bfill().iloc[0].tolist()
    pieces = []
    for number, (first, end) in enumerate(zip(firsts, [*firsts[1:], len(time)], strict=True)):
        frame = run.frame.copy()
        frame.loc[: first - 1, compared] = np.nan
        frame.loc[end:, compared] = np.nan
        if number:
            frame.loc[0, compared] = at_start
        name = f"{run.name}{_PIECE.format(number + 1, len(firsts))}"
        pieces.append(replace(run, name=name, frame=frame, faults=None))
    return pieces


def is_piece(run: Run) -> bool:
    """Whether a run is a piece of a log, simulated from the beginning of the log."""
    return _number(run) > 0


def _number(run: Run) -> int:
    """Return which piece of a log a run is, from 1; 0 for a run of its own."""
    named = re.search(r"_(\d+)of\d+$", run.name)
    return int(named[1]) if named else 0


def own_hours(observed: Observations) -> Observations:
    """Return a piece's observations without the log's first row, to draw them; a run's as given."""
    if _number(observed.run) < 2:
        return observed
    time, values, weights = observed.time_s, observed.values, observed.weights
    return replace(observed, time_s=time[1:], values=values[1:], weights=weights[1:])
