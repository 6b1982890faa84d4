"""Bearing friction with another exponent of speed than Palmgren's."""

from __future__ import annotations

import numpy as np

from plant_model.anatomy import bearings
from plant_model.effects.base import Effect, Inputs
from plant_model.effects.bearing_friction import add_to_sides, bearing_heat
from plant_model.parameters import FloatArray, Parameter


class FrictionSpeedExponent(Effect):
    """Heat of the bearings Q = Q_Palmgren (n / n_ref)^d; n_ref is half of the highest speed.

    Palmgren's viscous part grows with n^(5/3), the load part with n. The exponent is lower if oil
    is scarce (starvation, oil and air) and higher with churning grease and the balls' centrifugal
    load; 1 to 2.5 in total is engineering judgement. Origin of the heat in fast spindles: Bossmanns
    and Tu, J. Manuf. Sci. Eng. 123 (2001) 494-505, doi:10.1115/1.1349555. At n_ref the heat does
    not change, so d changes only the slope.
    """

    title = "Friction growing with another power of speed"
    explanation = (
        "The bearings' heat rises with speed more steeply, or less, than the usual law says."
    )
    parameters = {
        "deviation": Parameter(
            0.4, "1", -0.7, 0.9, "judgement: exponents of 1 to 2.5, Palmgren 5/3"
        )
    }
    physical = (-1.6, 3.0)
    needs = ("bearing_friction",)

    def prepare(self) -> None:
        """Find the bearings and the reference speed of each [r/min]."""
        highest = {entry.name: entry.most for entry in self.machine.inputs}
        self._bearings = [
            (item, item.refs["driven_by"][0], highest[item.refs["driven_by"][0]] / 2.0)
            for item in bearings(self.machine)
        ]

    def heat(
        self, inputs: Inputs, temperatures: FloatArray, states: FloatArray, out: FloatArray
    ) -> None:
        """Add the difference to Palmgren's heat."""
        for item, driver, reference in self._bearings:
            speed = np.abs(inputs[driver])
            relative = np.where(speed > 0.0, speed / reference, 1.0)
            change = relative ** self.own("deviation") - 1.0
            add_to_sides(self, item, change * bearing_heat(self, item, speed), out)
