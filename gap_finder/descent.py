"""One Levenberg-Marquardt descent: its damping, and when it has converged."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from gap_finder.linearise import Linearisation
from plant_model.parameters import FloatArray

ITERATIONS = 20
"""Maximum number of steps; set for time, on no data."""

ENOUGH = 1e-3
"""Relative improvement of the cost below which a descent has converged [1]; set on no data."""

SHARES = (0.0, 1 / 6.0, 1.0, 6.0)
"""Multiples of the last damping that are tried together [1]; set on no data."""

BOLD = 0.5
"""Share of the best trial's gain that suffices for a step with less damping [1]: always taking the
best single step creeps along narrow curved valleys. Set on no data."""


@dataclass(eq=False)
class Descent:
    """A descent from one starting point.

    Less damping is preferred if it gains nearly as much, as in Transtrum and Sethna,
    arXiv:1201.5885 (2012).

    Attributes
    ----------
    x : array
        Current point.
    cost : float
        Cost there.
    parts : list of Linearisation
        Every run, linearised about that point.
    damping : float
        In diagonals of the normal matrix [1].
    is_done : bool
        Whether it has converged, or no step helps.
    """

    x: FloatArray
    cost: float
    parts: list[Linearisation]
    damping: float = 1e-2
    is_done: bool = False

    @property
    def dampings(self) -> list[float]:
        """Dampings to try next."""
        return [self.damping * share for share in SHARES]

    def take(self, trials: FloatArray, costs: FloatArray) -> int | None:
        """Take one of the tried steps; return its index, or None if none helps.

        Parameters
        ----------
        trials : array, shape (len(SHARES), P)
            Points reached.
        costs : array, shape (len(SHARES),)
            Cost at each; NaN if the machine cannot be stepped there.
        """
        won = np.nan_to_num(self.cost - costs, nan=-np.inf)
        if not won.max() > 0.0:
            # It has converged, or already follows the slope with short steps.
            self.is_done = bool(won.max() > -ENOUGH * self.cost or self.damping > 1.0)
            self.damping *= SHARES[-1] / SHARES[1]
            return None
        taken = int(np.argmax(won >= BOLD * won.max()))
        self.is_done = bool(won.max() < ENOUGH * self.cost)
        self.x, self.cost = trials[taken], float(costs[taken])
        self.damping = max(self.damping * max(SHARES[taken], SHARES[1]), 1e-6)
        return taken
