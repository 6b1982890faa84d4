"""One Levenberg-Marquardt descent: its damping, and when it has converged."""

from __future__ import annotations

from dataclasses import dataclass

from gap_finder.linearise import Linearisation
from plant_model.parameters import FloatArray

ITERATIONS = 20
"""Maximum number of steps; set for time, on no data."""

ENOUGH = 1e-3
"""Relative improvement of the cost below which a descent has converged [1]; set on no data."""

GROWTH = 2.0
"""Factor on the damping after a first failure, and on itself after each further one: given by
Nielsen's method."""


@dataclass(eq=False)
class Descent:
    """A descent from one starting point.

    Damping follows the ratio of a step's gain to the gain that the linear model promises (Nielsen,
    Damping parameter in Marquardt's method, IMM-REP-1999-05, Technical University of Denmark).

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
    growth : float
        Factor on the damping if the next step fails [1].
    is_done : bool
        Whether it has converged.
    """

    x: FloatArray
    cost: float
    parts: list[Linearisation]
    damping: float = 1e-2
    growth: float = GROWTH
    is_done: bool = False

    def promised(self, gain: float) -> bool:
        """Return whether a step is worth taking that should lower the cost by *gain*.

        After a step that failed it is: damping makes any promise small.
        """
        self.is_done = self.growth == GROWTH and gain < ENOUGH * self.cost
        return not self.is_done

    def take(self, x: FloatArray, cost: float, parts: list[Linearisation], promised: float) -> None:
        """Move to *x* if the cost there is lower, and damp the next step accordingly.

        Parameters
        ----------
        x : array
        cost : float
            At *x*; infinite if the machine cannot be stepped there.
        parts : list of Linearisation
            Every run about *x*.
        promised : float
            Gain expected from the linear model.
        """
        gain = self.cost - cost
        self.is_done = abs(gain) < ENOUGH * self.cost
        if not gain > 0.0:
            self.damping *= self.growth
            self.growth *= GROWTH
            return
        self.x, self.cost, self.parts = x, cost, parts
        self.damping *= max(1.0 / 3.0, 1.0 - (2.0 * gain / promised - 1.0) ** 3)
        self.growth = GROWTH
