"""A lubricant that thins as the bearing warms."""

from __future__ import annotations

import numpy as np

from plant_model.effects.base import Effect, Inputs
from plant_model.effects.bearing_friction import LEAST, PALMGREN, friction_heat, torque_size
from plant_model.parameters import FloatArray, Parameter


class ViscosityTemperature(Effect):
    """Palmgren's viscous torque with nu(T) = nu0 exp(-b (T - T0)) instead of a constant nu0.

    T is the temperature of the bearing's inner side, T0 that at which the machine file's viscosity
    holds: ``viscosity_at`` of the bearing, 25 degC if left out. By the equation of ASTM D341,
    mineral oils of ISO VG 10 to 68 with a viscosity index near 95 thin by b = 0.032 to 0.050 per
    kelvin on average between 20 and 60 degC, faster when cold and slower when warm.
    """

    title = "Viscosity falling with temperature"
    explanation = "Friction falls as the bearing warms, because its oil thins."
    parameters = {
        "slope": Parameter(0.035, "1/K", 0.0, 0.06, "slopes of spindle oils by ASTM D341")
    }
    physical = (0.0, 0.2)
    temperature_dependent = True
    needs = ("bearing_friction",)

    def prepare(self) -> None:
        """Collect what does not change: stepping asks for the heat thousands of times."""
        self._thins = PALMGREN * self.own("slope")
        self._bearings = []
        for item in self.machine.of_kind("sources", "bearing"):
            size = torque_size(self.of(item, "f0"), self.of(item, "mean_diameter"))
            factor = self.scale_of("bearing_friction") * self.of(item, "count")
            inner, outer = (self.nodes(item, side)[0] for side in ("inner", "outer"))
            numbers = (factor * size, self.of(item, "viscosity") ** PALMGREN)
            more = (self.of(item, "viscosity_at"), self.of(item, "inner_share"))
            self._bearings.append((item.refs["driven_by"][0], inner, outer, *numbers, *more))

    def heat(
        self, inputs: Inputs, temperatures: FloatArray, states: FloatArray, out: FloatArray
    ) -> None:
        """Add the difference to the heat at constant viscosity."""
        for driver, inner, outer, size, thick, at, share in self._bearings:
            speed = inputs[driver]
            film = thick * np.abs(speed) ** PALMGREN
            thinned = film * np.exp(self._thins * (at - temperatures[..., inner]))
            change = size * (np.maximum(thinned, LEAST) - np.maximum(film, LEAST))
            power = friction_heat(speed, change)
            out[..., inner] += share * power
            out[..., outer] += (1.0 - share) * power
