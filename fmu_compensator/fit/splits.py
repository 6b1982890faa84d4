"""Training and validation runs of a comparison: split by run or by condition, never by row."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from measurement.errors import BadInput
from measurement.runs import Run


@dataclass(frozen=True)
class Split:
    """Training runs and runs to judge.

    Attributes
    ----------
    name : str
        What distinguishes the judged runs.
    train, validate : list of Run
        No run is in both.
    """

    name: str
    train: Sequence[Run]
    validate: Sequence[Run]


def leave_out(runs: Sequence[Run], by: str) -> list[Split]:
    """Return splits that leave out each run, or each speed spectrum, in turn.

    Parameters
    ----------
    runs : sequence of Run
        All runs.
    by : {"run", "speeds"}
        ``speeds``: runs at the same speeds are left out together, so that every model is judged in
        an unseen condition.

    Raises
    ------
    BadInput
        If there are fewer than two groups.
    """
    groups: dict[str, list[Run]] = {}
    for run in runs:
        groups.setdefault(run.name if by == "run" else _speeds(run), []).append(run)
    if len(groups) < 2:
        raise BadInput("compare", "", f"the runs make {len(groups)} group: two or more are needed")
    return [
        Split(name, [run for run in runs if run not in out], out) for name, out in groups.items()
    ]


def _speeds(run: Run) -> str:
    names = run.of_unit("rpm")
    if not names:
        return "speed not recorded"
    speeds = np.unique(np.round(run.frame[names[0]].dropna().abs().to_numpy(), -1))
    turning = [f"{speed:g}" for speed in speeds if speed]
    if len(turning) > 6:
        return f"{len(turning)} speeds up to {turning[-1]} rpm"
    return (" and ".join(turning) or "0") + " rpm"
