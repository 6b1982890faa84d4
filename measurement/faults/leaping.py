"""The odds that a signal leaps, used by every check that needs them.

An ordinary move from one reading to the next has the size of the largest neighbouring move in the
same direction, or of the channel's usual move; so a noisy, coarse or rarely read sensor, or a
machine that was just switched, sets its own scale. A leap has the size of the channel's range in
the whole run. Both have Laplace distributions, and a leap must be more likely by the odds that any
one of the readings is a leap.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from measurement.faults.series import IntArray, valid
from measurement.resampling import FINEST_K, GAP_INTERVALS, WRONG, FloatArray
from measurement.runs import Run

BESIDE = 3
"""Number of moves on each side that define what is ordinary; a change that lasts for fewer readings
has come back at once [1]. Set on the planted faults."""

OF_THREE = 1.0 + 1.0 / 2.0 + 1.0 / 3.0
"""Mean of the largest of three Laplace magnitudes over their scale [1]: half of the six moves next
to one have its direction. Given by arithmetic."""


@dataclass(frozen=True)
class Moves:
    """The moves of a channel from reading to reading.

    Attributes
    ----------
    rows : array, shape (n,)
        Rows of the run that have a reading.
    values : array, shape (n,)
        The readings [K, um].
    by : array, shape (n - 1,)
        From each reading to the next [K, um].
    odds : array, shape (n - 1,)
        Logarithm of the odds of a leap [1].
    """

    rows: IntArray
    values: FloatArray
    by: FloatArray
    odds: FloatArray

    def leaps(self) -> list[int]:
        """Return the indices of the readings after which the channel leaps."""
        return np.flatnonzero(self.odds > 0.0).tolist()


def moves_of(run: Run, column: str) -> Moves:
    """Return the moves of a channel of a run; a move across a pause of the record is no leap."""
    there, values = valid(run, column)
    intervals = np.diff(run.time_s[there])
    by = np.diff(values)
    odds = leap_odds(values, FINEST_K if column in run.temperatures else 0.0)
    if intervals.size:
        odds[intervals > GAP_INTERVALS * np.median(intervals)] = -np.inf
    return Moves(there, values, by, odds)


def leap_odds(values: FloatArray, finest: float) -> FloatArray:
    """Return the logarithm of the odds that each move is a leap, shape (n - 1,) [1].

    Parameters
    ----------
    values : array, shape (n,)
        Consecutive readings, none missing. Repeated readings are skipped: a channel that is read
        rarely and held moves only when it is read.
    finest : float
        A move of this size is ordinary [K, um].
    """
    by = np.diff(values)
    odds = np.full(len(by), -np.inf)
    moved = np.flatnonzero(by)
    if not moved.size:
        return odds
    size, signed = np.abs(by[moved]), by[moved]
    along = np.where(signed > 0.0, _largest_beside(signed), _largest_beside(-signed))
    usual = np.maximum(along / OF_THREE, max(float(np.median(size)), finest))
    whole = np.maximum(float(np.ptp(values)), usual)
    gain = np.log(usual / whole) + size / usual - size / whole
    odds[moved] = gain - np.log(len(by) / WRONG)
    return odds


def _largest_beside(steps: FloatArray) -> FloatArray:
    """Return the largest neighbour of each step; 0 if none is larger than that."""
    padded = np.pad(steps, BESIDE)
    shifts = [n for n in range(2 * BESIDE + 1) if n != BESIDE]
    return np.asarray(np.max([padded[n : n + len(steps)] for n in shifts], axis=0))
