"""Which training runs are left out together: similar to the rest, or different from it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from fmu_compensator.fit.data import PreparedRun
from fmu_compensator.fit.run_conditions import conditions_in

LIKE, UNLIKE = "like", "unlike"
FOLDS = 5
"""Number of like folds, left out in turn: given by Hastie, Tibshirani and Friedman, The Elements of
Statistical Learning, 2nd ed., 7.10.1, which recommends five or ten."""
THIRDS = 3
"""Parts of the runs along a condition; the first and the last are left out in turn. Fewer runs do
not suffice for training and judging: given by two ends and a middle."""


@dataclass(frozen=True)
class Fold:
    """Runs left out together.

    Attributes
    ----------
    name : str
        What distinguishes them.
    kind : {"like", "unlike"}
        Whether the remaining runs cover the same conditions.
    out : tuple of int
        Their places among the runs.
    """

    name: str
    kind: str
    out: tuple[int, ...]


def folds_of(runs: Sequence[PreparedRun]) -> list[Fold]:
    """Return the folds; none with fewer than three runs.

    A like fold takes every n-th run. An unlike fold takes the third of the runs at either end of a
    condition, so that the model must extrapolate: temperature at the start, spindle speed, rise of
    temperature, and the order in which the runs are given.
    """
    count = len(runs)
    if count < THIRDS:
        return []
    folds = []
    for first in range(min(count, FOLDS)):
        places = tuple(range(first, count, FOLDS))
        names = [runs[place].name for place in places]
        name = names[0] if len(names) == 1 else f"{names[0]} and every {FOLDS}th from there"
        folds.append(Fold(name, LIKE, places))
    size = round(count / THIRDS)
    taken: list[tuple[int, ...]] = []
    for low, high, values in _conditions(runs):
        if not np.isfinite(values).all() or np.ptp(values) == 0.0:
            continue
        order = np.argsort(values, kind="stable")
        for name, ends in ((low, order[:size]), (high, order[-size:])):
            out = tuple(sorted(int(place) for place in ends))
            if out not in taken:
                taken.append(out)
                folds.append(Fold(name, UNLIKE, out))
    return folds


def _conditions(runs: Sequence[PreparedRun]) -> list[tuple[str, str, np.ndarray]]:
    """Return the conditions: names of the low and the high end, and a value per run."""
    values = [conditions_in(run.temperatures, run.speed, run.time_s) for run in runs]
    start, rise, speed, _ = np.array(values).T
    return [
        ("coldest starts", "warmest starts", start),
        ("slowest", "fastest", speed),
        ("smallest rises", "largest rises", rise),
        ("first runs", "last runs", np.arange(len(runs), dtype=float)),
    ]
