"""How a control applies the offsets it receives: increments, slew limit, saturation, resolution."""

from __future__ import annotations

import math

from plant_model.machine import Axis

MOST_ALLOWANCE = 1e15
"""Increments that any step allows at most: farther than any axis goes, and given by
arithmetic a whole number still."""


class AxisOffset:
    """One axis with the "feedback integral method".

    The control integrates increments of its own resolution until their sum equals the offset
    received: it never moves faster than the slew limit and never leaves the saturation limits.

    Parameters
    ----------
    axis : Axis
        Limits.
    """

    def __init__(self, axis: Axis) -> None:
        self._axis = axis
        # Without a resolution an increment is as fine as a double allows in practice.
        self._increment = axis.resolution_um or 1e-9
        self._counts = 0
        self._allowance = 0.0

    @property
    def in_force(self) -> float:
        """The offset in force [um]."""
        return self._counts * self._increment

    def step(self, wanted: float, step_s: float) -> float:
        """Return the offset in force [um] after *step_s*, moving towards *wanted* [um].

        A value that is not finite is not an offset: the axis stays where it is.
        """
        axis = self._axis
        if not math.isfinite(wanted):
            return self.in_force
        target = min(max(wanted, -axis.limit_um), axis.limit_um)
        missing = round(target / self._increment) - self._counts
        # Travel that is less than an increment is kept for the next step, but not hoarded.
        self._allowance += axis.slew_um_per_s * step_s / self._increment
        self._allowance = min(self._allowance, MOST_ALLOWANCE)
        reach = int(self._allowance)
        move = min(max(missing, -reach), reach)
        self._allowance = min(self._allowance - abs(move), 1.0)
        self._counts += move
        return self.in_force

    def state(self) -> list[float]:
        """Return what a continued trajectory needs."""
        return [self._counts, self._allowance]

    def restore(self, state: list[float]) -> None:
        """Continue from :meth:`state`."""
        self._counts, self._allowance = int(state[0]), state[1]
