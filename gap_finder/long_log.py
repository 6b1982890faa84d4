"""One long recording as several runs: each begins as warm as the one before left the machine.

A log of days holds what hidden parts do over hours, and no sensor tells how warm they are when an
hour of it begins. So a piece is driven from the beginning of the log, by what was recorded, and
compared only from its own beginning on: then hidden parts start where the pieces before left them.
"""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np

from gap_finder.observations import INDEPENDENT_S
from measurement.runs import TIME, Run
from plant_model.machine import Machine

_PIECE = "_{}of{}"


def pieces_of(machine: Machine, run: Run, hours: float) -> list[Run]:
    """Return a run in pieces of so many hours; itself if it is not longer.

    Parameters
    ----------
    machine : Machine
        What drives it stays in every piece from the first row on.
    run : Run
    hours : float
        Of a piece [h].

    Returns
    -------
    list of Run
        Each with all rows up to its end. Of what is only compared, the rows before its beginning
        hold nothing, but for the first row of the log, where every part starts.
    """
    time = run.time_s
    starts = np.arange(time[0], time[-1], 3600.0 * hours)
    firsts = np.searchsorted(time, starts - 1e-6)
    # A last piece without one independent value of its own goes with the one before.
    firsts = np.concatenate([firsts[:1], firsts[1:][time[-1] - time[firsts[1:]] >= INDEPENDENT_S]])
    if len(firsts) < 2:
        return [run]
    driving = {TIME, *(entry.column for entry in machine.inputs)}
    compared = [name for name in run.frame.columns if name not in driving]
    at_start = _first_readings(run, compared)
    pieces = []
    for number, (first, end) in enumerate(zip(firsts, [*firsts[1:], len(time)], strict=True)):
        frame = run.frame.iloc[:end].copy()
        frame.loc[: first - 1, compared] = np.nan
        if number:
            frame.loc[0, compared] = at_start
        name = f"{run.name}{_PIECE.format(number + 1, len(firsts))}"
        pieces.append(replace(run, name=name, frame=frame, faults=None))
    return pieces


def is_piece(run: Run) -> bool:
    """Tell whether a run is a piece of a log, and is driven from the log's beginning."""
    return re.search(r"_\d+of\d+$", run.name) is not None


def _first_readings(run: Run, columns: list[str]) -> list[float]:
    """Return the first value that each column has, NaN if none."""
    firsts = []
    for name in columns:
        readings = run.frame[name].dropna()
        firsts.append(float(readings.iloc[0]) if len(readings) else float("nan"))
    return firsts
