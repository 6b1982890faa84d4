"""A lubricant that thins as the bearing warms."""

from __future__ import annotations

import numpy as np

from plant_model.effects.base import Effect, Inputs
from plant_model.effects.bearing_friction import add_to_sides, friction_heat, viscous_torque
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
        """Find the bearings."""
        self._bearings = self.machine.of_kind("sources", "bearing")

    def heat(
        self, inputs: Inputs, temperatures: FloatArray, states: FloatArray, out: FloatArray
    ) -> None:
        """Add the difference to the heat at constant viscosity."""
        for item in self._bearings:
            speed = inputs[item.refs["driven_by"][0]]
            f0, nu0 = self.of(item, "f0"), self.of(item, "viscosity")
            diameter = self.of(item, "mean_diameter")
            warm = temperatures[..., self.nodes(item, "inner")[0]] - self.of(item, "viscosity_at")
            nu = nu0 * np.exp(-self.own("slope") * warm)
            change = viscous_torque(f0, nu, speed, diameter)
            change = change - viscous_torque(f0, nu0, speed, diameter)
            factor = self.scale_of("bearing_friction") * self.of(item, "count")
            add_to_sides(self, item, factor * friction_heat(speed, change), out)
