"""Runs that began warm: an imported log marks them, and they are no cold starts.

A compensator counts temperatures and drift from a run's first row. Where the machine is warm then,
drift is there already, and falls while the thermometers fall: another law than the one from cold.
"""

from __future__ import annotations

from collections.abc import Sequence

from measurement.runs import Run

WARM_START = "warm_start_1"
"""1 in every row of a run that began warm, 0 of one that began cold, absent where nobody knows."""


def began_warm(run: Run) -> bool:
    """Return whether a run says that it began while the machine was warm."""
    if WARM_START not in run.frame.columns:
        return False
    said = run.frame[WARM_START].dropna()
    return bool(len(said)) and bool(said.iloc[0] == 1.0)


def cold_starts(runs: Sequence[Run]) -> tuple[list[Run], str]:
    """Leave out runs that say that they began warm, unless all of them do.

    Parameters
    ----------
    runs : sequence of Run
        In any order; those that do not say how they began count as cold.

    Returns
    -------
    runs : list of Run
    note : str
        What was left out, or that nothing else is there; empty if no run says so.
    """
    warm = named_warm(runs)
    cold = [run for run in runs if not began_warm(run)]
    if not warm:
        return cold, ""
    if not cold:
        return list(runs), "all runs began warm: the result holds for warm restarts only"
    return cold, f"left out, since the machine was warm when they began: {warm}"


def named_warm(runs: Sequence[Run]) -> str:
    """Return the names of the runs that say that they began warm, with commas between.

    Parameters
    ----------
    runs : sequence of Run
    """
    return ", ".join(dict.fromkeys(run.name for run in runs if began_warm(run)))
