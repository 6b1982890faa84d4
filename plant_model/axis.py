"""A control applying the offsets it receives: increments, slew limit, saturation, resolution."""

from __future__ import annotations

import math

from plant_model.machine import Axis

MOST_ALLOWANCE = 1e15
"""Largest allowance per step, in increments: farther than any axis travels, and given by
arithmetic, since a double still holds it as a whole number."""


class AxisOffset:
    """One axis that uses the "feedback integral method".

    The control sums increments of its own resolution until the sum equals the offset received. It
    never moves faster than the slew limit and never leaves the saturation limits.

    Parameters
    ----------
    axis : Axis
        Limits.
    """

    def __init__(self, axis: Axis) -> None:
        self._axis = axis
        self._increment = axis.increment_um
        self._counts = 0
        self._allowance = 0.0

    @property
    def in_force(self) -> float:
        """The offset in force [um]."""
        return self._counts * self._increment

    def step(self, wanted: float, step_s: float) -> float:
        """Return the offset in force [um] after *step_s*, moving towards *wanted* [um].

        If *wanted* is not finite, the axis stays where it is.
        """
        axis = self._axis
        if not math.isfinite(wanted):
            return self.in_force
        target = min(max(wanted, -axis.farthest_um), axis.farthest_um)
        missing = round(target / self._increment) - self._counts
        # Travel of less than an increment is kept for the next step, but does not accumulate.
        self._allowance += axis.slew_um_per_s * step_s / self._increment
        self._allowance = min(self._allowance, MOST_ALLOWANCE)
        reach = int(self._allowance)
        move = min(max(missing, -reach), reach)
        self._allowance = min(self._allowance - abs(move), 1.0)
        self._counts += move
        return self.in_force

    def state(self) -> list[float]:
        """Return the state needed to continue."""
        return [self._counts, self._allowance]

    def restore(self, state: list[float]) -> None:
        """Continue from :meth:`state`."""
        self._counts, self._allowance = int(state[0]), state[1]
