"""Runs that began warm, which an imported log marks.

A compensator counts temperatures and drift from a run's first row. If the machine is already warm
then, it has already drifted, and the drift decreases as the thermometers cool: a different law from
that of a cold start.
"""

from __future__ import annotations

from collections.abc import Sequence

from measurement.runs import Run

WARM_START = "warm_start_1"
"""1 in every row of a run that began warm, 0 if it began cold, absent if unknown."""


def began_warm(run: Run) -> bool:
    """Return whether a run is marked as begun on a warm machine."""
    if WARM_START not in run.frame.columns:
        return False
    said = run.frame[WARM_START].dropna()
    return bool(len(said)) and bool(said.iloc[0] == 1.0)


def cold_starts(runs: Sequence[Run]) -> tuple[list[Run], str]:
    """Leave out runs that are marked as begun warm, unless all of them are.

    Parameters
    ----------
    runs : sequence of Run
        In any order; unmarked runs count as cold.

    Returns
    -------
    runs : list of Run
    note : str
        What was left out, or that there are no other runs; empty if no run began warm.
    """
    warm = named_warm(runs)
    cold = [run for run in runs if not began_warm(run)]
    if not warm:
        return cold, ""
    if not cold:
        return list(runs), "all runs began warm: what they teach holds for warm restarts"
    note = f"left out, since the machine was warm when they began: {warm}"
    return cold, f"{note}; use them by themselves, or without the column {WARM_START}"


def named_warm(runs: Sequence[Run]) -> str:
    """Return the names of the runs that are marked as begun warm, separated by commas.

    Parameters
    ----------
    runs : sequence of Run
    """
    return ", ".join(dict.fromkeys(run.name for run in runs if began_warm(run)))
