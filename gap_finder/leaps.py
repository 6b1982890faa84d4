"""Leaps of the spindle nose: the instants at which it jumped in a run.

A bearing slips when a certain force is reached. A slightly wrong model slips at other instants and
then explains nothing, even if its law is right. The leaps themselves are obvious in the data.

They are detected in binned residuals, in which a slip is one change or two, repeated in the run.
Fitting lines to the rows before and after, as in `probe_steps`, misses most of them.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.ndimage import maximum_filter1d, median_filter

from gap_finder.observations import DISPLACEMENT_TOLERANCE, Observations
from gap_finder.probe_steps import ROWS, moved_by_elongation
from plant_model.drive import Drive
from plant_model.effect_names import leaps_of
from plant_model.machine import Machine
from plant_model.parameters import FloatArray

OUTSTANDING = 8.0
"""A leap is at least this many times the scatter of changes elsewhere in the run [1]; set on no
data."""


@dataclass(frozen=True)
class Leaps:
    """Leaps of the elongation in one run.

    Attributes
    ----------
    time_s : array, shape (L,)
        First observation after each [s].
    sign : array, shape (L,)
        +1 or -1.
    """

    time_s: FloatArray
    sign: FloatArray

    def marked(self, observed: Observations, key: str) -> Observations:
        """Return observations with these leaps added to the inputs of an effect."""
        return observed.with_series(leaps_of(key), self._at_ends)

    def _at_ends(self, drive: Drive) -> FloatArray:
        seen = np.zeros(len(drive.grid) - 1)
        # The step that ends at the observation, or at the first grid instant after it.
        ends = np.searchsorted(drive.grid[1:], self.time_s - 1e-6)
        inside = ends < len(seen)
        seen[ends[inside]] = self.sign[inside]
        return seen


def leaps_in(machine: Machine, observed: Observations, base: FloatArray) -> Leaps:
    """Find where the elongation leaps.

    Parameters
    ----------
    machine : Machine
    observed : Observations
    base : array, shape (K, C)
        Channels as modelled; subtracted, so that known quick changes do not count as leaps.
    """
    by_channel = moved_by_elongation(machine)
    shown = np.array([by_channel.get(name, 0.0) for name in observed.channels])
    # Least squares over all channels that elongation moves, as far as each was measured.
    pull = observed.weights**2 * shown
    strength = np.sum(pull * shown, axis=1)
    residual = np.sum(pull * (np.nan_to_num(observed.values) - base), axis=1)
    seen = strength > 0.0
    elongation = residual[seen] / strength[seen]
    if len(elongation) < 2 * ROWS:
        return Leaps(np.zeros(0), np.zeros(0))
    change = np.diff(elongation)
    leap = change - median_filter(change, ROWS + 1, mode="nearest")
    size = np.abs(leap)
    usual = 1.4826 * float(np.median(size))
    stands_out = size > max(OUTSTANDING * usual, DISPLACEMENT_TOLERANCE)
    # One leap may be spread over two changes: the larger one counts.
    stands_out &= size == maximum_filter1d(size, 3)
    at = np.flatnonzero(stands_out)
    return Leaps(observed.time_s[seen][at + 1], np.sign(leap[at]))
