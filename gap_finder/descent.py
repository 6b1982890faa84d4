"""Levenberg-Marquardt, one descent: how boldly it goes, and when it has arrived."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from plant_model.parameters import FloatArray

ITERATIONS = 20
"""Steps at most; set for time, on no data."""

ENOUGH = 1e-3
"""Relative improvement of the cost below which a descent has arrived [1]; set on no data."""

SHARES = (0.0, 1 / 6.0, 1.0, 6.0)
"""Multiples of the last damping that are tried at once [1]; set on no data."""

BOLD = 0.5
"""Share of what the best of these wins for which a step with less damping is taken [1]: in a
narrow curved valley, whoever takes the best single step creeps. Set on no data."""


@dataclass(eq=False)
class Descent:
    """One start on its way down.

    Less damping is preferred where it wins nearly as much, as in Transtrum and Sethna,
    arXiv:1201.5885 (2012).

    Attributes
    ----------
    x : array
        Where it is.
    cost : float
        There.
    damping : float
        In diagonals of the normal matrix [1].
    is_done : bool
        Whether it has arrived, or no step helps.
    """

    x: FloatArray
    cost: float
    damping: float = 1e-2
    is_done: bool = False

    @property
    def dampings(self) -> list[float]:
        """What is to be tried next."""
        return [self.damping * share for share in SHARES]

    def take(self, trials: FloatArray, costs: FloatArray) -> int | None:
        """Take one of the steps tried; return which, or None if none helps.

        Parameters
        ----------
        trials : array, shape (len(SHARES), P)
            Where they lead.
        costs : array, shape (len(SHARES),)
            There; NaN where the machine cannot be stepped.
        """
        won = np.nan_to_num(self.cost - costs, nan=-np.inf)
        if not won.max() > 0.0:
            # It has arrived, or goes down the slope already, however short the step.
            self.is_done = bool(won.max() > -ENOUGH * self.cost or self.damping > 1.0)
            self.damping *= SHARES[-1] / SHARES[1]
            return None
        taken = int(np.argmax(won >= BOLD * won.max()))
        self.is_done = bool(won.max() < ENOUGH * self.cost)
        self.x, self.cost = trials[taken], float(costs[taken])
        self.damping = max(self.damping * max(SHARES[taken], SHARES[1]), 1e-6)
        return taken
