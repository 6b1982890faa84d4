"""Finds thermometers that are swapped in one run relative to the others: two plugs exchanged.

How each thermometer follows the mean of all is learnt from the other runs; swapping two does not
change that mean. A run is doubted if exchanging two thermometers makes it far more likely.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from measurement.doubts.readings import ASTRAY_PER_K
from measurement.doubts.warming import FEWEST_LIKE_RUNS, rises
from measurement.resampling import FINEST_K, LAG_S, WARMS_K, WRONG, FloatArray
from measurement.runs import Run


def swapped(runs: Sequence[Run]) -> list[tuple[str, str]]:
    """Return pairs of thermometers that are far more likely swapped in some runs."""
    names = [name for name in runs[0].temperatures if all(_is_whole(run, name) for run in runs)]
    if len(runs) < FEWEST_LIKE_RUNS or len(names) < 3:
        return []
    moments = [_moments(run, names) for run in runs]
    runs_of: dict[tuple[int, int], list[str]] = {}
    for place, run in enumerate(runs):
        if moments[place].span_k < WARMS_K:
            continue
        others = [entry for at, entry in enumerate(moments) if at != place]
        missed = _missed(moments[place], others)
        usual = [
            np.diag(_missed(here, [other for other in others if other is not here]))
            for here in others
        ]
        pair = _swap(missed, np.array(usual))
        if pair:
            runs_of.setdefault(pair, []).append(run.name)
    return [
        (
            names[first],
            f"behaves like {names[second]} of the other runs, and that one like it, in "
            f"{', '.join(where)}: swapped there?",
        )
        for (first, second), where in runs_of.items()
    ]


def _swap(missed: FloatArray, usual: FloatArray) -> tuple[int, int] | None:
    """Return the pair that is far more likely swapped, or None.

    Parameters
    ----------
    missed : array, shape (thermometers, thermometers)
        Residual of the second thermometer if it is in the first one's place [K].
    usual : array, shape (other runs, thermometers)
        Residual of each thermometer in its own place in the other runs [K].
    """
    count = len(missed)
    # The scatter of all thermometers counts as one additional run of each.
    degrees = len(usual) + 1.0
    shared = float(np.median(usual)) ** 2
    scale = np.sqrt((shared + (usual**2).sum(axis=0)) / degrees + FINEST_K**2)
    log = -0.5 * (degrees + 1) * np.log1p((missed / scale[:, None]) ** 2 / degrees)
    # A thermometer that fits nowhere is wrong, not swapped.
    own = np.maximum(np.diag(log), np.log(scale * ASTRAY_PER_K))
    gain = log + log.T - own[:, None] - own[None, :]
    first, second = divmod(int(np.argmax(gain)), count)
    pairs = count * (count - 1) / 2
    return (first, second) if gain[first, second] > math.log(pairs / WRONG) else None


class _Moments(NamedTuple):
    """Means over a run's rows of products of the mean rise, now and lagged, and all rises [K2]."""

    basis: FloatArray
    both: FloatArray
    squares: FloatArray
    span_k: float


def _missed(here: _Moments, others: Sequence[_Moments]) -> FloatArray:
    """Return a run's residual of each thermometer in each place, by the other runs' laws [K]."""
    basis = sum(other.basis for other in others) + 1e-9 * np.eye(2)
    laws = np.linalg.solve(basis, sum(other.both for other in others))
    expected = np.einsum("ki,kl,li->i", laws, here.basis, laws)
    left = here.squares[None, :] - 2.0 * laws.T @ here.both + expected[:, None]
    return np.asarray(np.sqrt(np.maximum(left, 0.0)), dtype=np.float64)


def _moments(run: Run, names: Sequence[str]) -> _Moments:
    rise = rises(run, names)
    mean, time = rise.mean(axis=1), run.time_s
    # A thermometer that lags follows the mean of this much earlier.
    both = np.column_stack([mean, np.interp(time - LAG_S, time, mean)])
    rows = float(len(rise))
    return _Moments(
        both.T @ both / rows, both.T @ rise / rows, (rise**2).mean(axis=0), float(np.ptp(mean))
    )


def _is_whole(run: Run, name: str) -> bool:
    return name in run.frame and bool(run.frame[name].notna().any())
