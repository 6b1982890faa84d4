"""Oscillations: periods common to the residuals of all runs, and the phase of each run."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from scipy.ndimage import gaussian_filter1d

from gap_finder.keys import unused_with
from gap_finder.linearise import modelled, simulate_at
from gap_finder.observations import BIN_S, INDEPENDENT_S, Observations
from plant_model.effect_names import name_of
from plant_model.effects import catalogue
from plant_model.machine import Machine
from plant_model.parameters import FloatArray

PHASES = np.arange(0.0, 1.0, 1.0 / 24.0)
"""Phases that are tried, as shares of a cycle [1]."""

MOST_TRIED = 3
"""Number of periods, and of relay settings, that are tried, the strongest in the residuals first;
set for time, on no data."""


def quick(observed: Observations, weighted: FloatArray) -> FloatArray:
    """Return weighted residuals or responses, (N,), without slow changes."""
    return without_slow(weighted.reshape(len(observed.time_s), -1), axis=0).reshape(-1)


def without_slow(series: FloatArray, axis: int) -> FloatArray:
    """Return binned series, along an axis, without slow changes."""
    return np.asarray(series - gaussian_filter1d(series, INDEPENDENT_S / BIN_S, axis=axis))


def likely_periods(
    observed: Sequence[Observations], shown: Sequence[FloatArray], low: float, high: float
) -> list[float]:
    """Return the periods from *low* to *high* [min] that are strongest in the residuals.

    Parameters
    ----------
    observed : sequence of Observations
    shown : sequence of array, each (N,)
        Weighted residuals without slow changes.
    low, high : float

    Notes
    -----
    The power at a period is that of the best sine and cosine for each run and channel separately
    (Lomb's periodogram), summed over all.
    """
    # only here: it takes as long to load as all else
    from scipy.signal import find_peaks, lombscargle

    longest = max(run.time_s[-1] - run.time_s[0] for run in observed)
    # Two periods that differ by this much are a quarter of a cycle apart at the end of a run.
    step = 1.0 + low * 60.0 / (4.0 * longest)
    periods = low * step ** np.arange(int(np.log(high / low) / np.log(step)) + 1)
    power = np.zeros(len(periods))
    for run, residual in zip(observed, shown, strict=True):
        for column in residual.reshape(len(run.time_s), -1).T:
            power += lombscargle(run.time_s, column, 2.0 * np.pi / (60.0 * periods))
    peaks = find_peaks(np.concatenate([[0.0], power, [0.0]]))[0] - 1
    strongest = peaks[np.argsort(-power[peaks])][:MOST_TRIED]
    return [float(periods[i]) for i in strongest]


def in_step(machine: Machine, observed: Observations) -> Observations:
    """Return a run's observations with its own phase of every effect that oscillates."""
    for name in machine.effects:
        effect = catalogue()[name_of(name)]
        if not effect.swings or effect.swings[1] in unused_with(machine, name):
            continue
        key = f"effects.{name}.{effect.swings[1]}"
        if key in observed.own:
            continue
        shown = modelled(simulate_at(machine, observed, {key: PHASES}), observed)
        cost = [float(np.sum(quick(observed, left) ** 2)) for left in observed.weighted(shown)]
        observed = replace(observed, own={**observed.own, key: float(PHASES[int(np.argmin(cost))])})
    return observed
