"""One Levenberg-Marquardt descent: its damping, and when it has converged."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from gap_finder.likelihood import Quadratic
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


@dataclass(frozen=True)
class Point:
    """Parameters, and what is known about them.

    Attributes
    ----------
    x : array, shape (P,)
        In the fitting scale.
    parts : tuple of Linearisation
        Every run, linearised about them.
    about : Quadratic
        The cost about them, by these.
    expected : float
        The least cost, by this.
    """

    x: FloatArray
    parts: tuple[Linearisation, ...]
    about: Quadratic
    expected: float

    @property
    def cost(self) -> float:
        """The cost there."""
        return self.about.cost


@dataclass(eq=False)
class Descent:
    """A descent from one starting point.

    Less damping is preferred if it gains nearly as much, as in Transtrum and Sethna,
    arXiv:1201.5885 (2012).

    Attributes
    ----------
    at : Point
        Where it is.
    damping : float
        In diagonals of the normal matrix [1].
    is_done : bool
        Whether it has converged, or no step helps.
    fell : float
        How much its last step lowered the least cost that is expected.
    """

    at: Point
    damping: float = 1e-2
    is_done: bool = False
    fell: float = np.inf

    @property
    def dampings(self) -> list[float]:
        """Dampings to try next."""
        return [self.damping * share for share in SHARES]

    def may_reach(self, cost: float) -> bool:
        """Whether its derivatives promise a cost, or will after another step like its last.

        From far away they promise too little, and more with every step.
        """
        return self.at.expected - max(self.fell, 0.0) <= cost

    def move(self, at: Point) -> None:
        """Take a step to another point."""
        self.fell, self.at = self.at.expected - at.expected, at

    def best_of(self, costs: FloatArray) -> int | None:
        """Return which of the tried steps to take, or None if none helps.

        Parameters
        ----------
        costs : array, shape (len(SHARES),)
            Cost after each; NaN if the machine cannot be stepped there.
        """
        won = np.nan_to_num(self.at.cost - costs, nan=-np.inf)
        if not won.max() > 0.0:
            # It has converged, or already follows the slope with short steps.
            self.is_done = bool(won.max() > -ENOUGH * self.at.cost or self.damping > 1.0)
            self.damping *= SHARES[-1] / SHARES[1]
            return None
        taken = int(np.argmax(won >= BOLD * won.max()))
        self.is_done = bool(won.max() < ENOUGH * self.at.cost)
        self.damping = max(self.damping * max(SHARES[taken], SHARES[1]), 1e-6)
        return taken
