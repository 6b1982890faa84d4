"""Finds displacements whose sign contradicts the other runs or their name."""

from __future__ import annotations

import re
from collections.abc import Sequence

import numpy as np

from measurement.doubts.warming import FEWEST_LIKE_RUNS, rises
from measurement.resampling import FINEST_K, WARMS_K, FloatArray
from measurement.runs import Run

EXPLAINED = 0.7
"""Once its sign is reversed, the other runs explain at least this share of a flipped run; likewise
the warming explains a growth whose sign can be judged [1].

Set on 30 measured runs of a lathe with two displacements: none of the 60 is doubted as measured,
and exactly the flipped one is doubted in 35 of 60 cases; see the tests of this module."""
_GROWTH = re.compile(r"growth|elong|axial|dehnung|laengung|wachstum", re.IGNORECASE)


def doubted_signs(runs: Sequence[Run], warm: Sequence[FloatArray]) -> list[tuple[str, str]]:
    """Return displacements with a doubtful sign in runs of one machine, each with a text.

    *warm* is each run's `warming` [K].
    """
    doubts = []
    for name in runs[0].displacements:
        present = [(run, rise) for run, rise in zip(runs, warm, strict=True) if name in run.frame]
        if _GROWTH.search(name) and _falls(present, name):
            text = "falls while warming, but growth should rise: flipped? then set sign = -1"
            doubts.append((name, text))
        odd = flipped([run for run, _ in present], name)
        if odd:
            text = f"has the opposite sign in {', '.join(odd)} from the other runs: flipped there?"
            doubts.append((name, text))
    return doubts


def _falls(present: Sequence[tuple[Run, FloatArray]], name: str) -> bool:
    """Return whether a displacement falls with warming in every run in which it follows it."""
    signs = []
    for run, warm in present:
        values = run.frame[name].to_numpy()
        known = np.isfinite(values) & np.isfinite(warm)
        if known.sum() < 10 or np.ptp(warm[known]) < WARMS_K or not np.ptp(values[known]):
            continue
        relation = float(np.corrcoef(values[known], warm[known])[0, 1])
        if relation**2 >= EXPLAINED:
            signs.append(relation > 0.0)
    return bool(signs) and not any(signs)


def flipped(runs: Sequence[Run], name: str) -> list[str]:
    """Return the runs in which a displacement is the opposite of what the others predict.

    For each run, a ridge regression on the temperature rises is fitted to the others. The sign is
    doubted if the reversed prediction explains `EXPLAINED` of the measured sum of squares.
    """
    shared = [column for column in runs[0].temperatures if all(column in run.frame for run in runs)]
    if len(runs) < FEWEST_LIKE_RUNS or not shared:
        return []
    each = [rises(run, [*shared, name]) for run in runs]
    risen, moved = [part[:, :-1] for part in each], [part[:, -1] for part in each]
    usable = np.all([np.isfinite(part).all(axis=0) for part in risen], axis=0)
    if not usable.any() or not all(np.isfinite(part).all() for part in moved):
        return []
    risen = [part[:, usable] for part in risen]
    squares = [part.T @ part for part in risen]
    products = [part.T @ drift for part, drift in zip(risen, moved, strict=True)]
    # The reading uncertainty of a rise damps the weights.
    damping = FINEST_K**2 * sum(len(part) for part in risen) * np.eye(int(usable.sum()))
    odd = []
    for at, run in enumerate(runs):
        weights = np.linalg.solve(
            np.sum(squares, axis=0) - squares[at] + damping, np.sum(products, axis=0) - products[at]
        )
        if is_opposite(moved[at], risen[at] @ weights):
            odd.append(run.name)
    # If most runs disagree, the few others are the flipped ones.
    return odd if 2 * len(odd) < len(runs) else [run.name for run in runs if run.name not in odd]


def is_opposite(moved: FloatArray, predicted: FloatArray) -> bool:
    """Whether a prediction explains `EXPLAINED` of a displacement with the opposite sign.

    Against compensators fitted to other runs of the lathe, in three splits, the largest share of
    some 120 displacements as measured is 0.36.

    Parameters
    ----------
    moved, predicted : array, shape (T,)
        Since the start [um].
    """
    total, turned = float(moved @ moved), moved + predicted
    return total > 0.0 and 1.0 - float(turned @ turned) / total >= EXPLAINED
