"""A lubricant that thins as the bearing warms."""

from __future__ import annotations

import numpy as np

from plant_model.anatomy import incidence
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
        bearings = self.machine.of_kind("sources", "bearing")
        self._drivers = [item.refs["driven_by"][0] for item in bearings]
        self._inner, outer = (
            [self.nodes(item, side)[0] for item in bearings] for side in ("inner", "outer")
        )
        self._thins = PALMGREN * self.own("slope")[..., None]
        self._at, share = (
            self.table([self.of(item, name) for item in bearings])
            for name in ("viscosity_at", "inner_share")
        )
        self._thick = self.table([self.of(item, "viscosity") ** PALMGREN for item in bearings])
        scale = self.scale_of("bearing_friction")
        factors = [scale * self.of(item, "count") for item in bearings]
        numbers = [(self.of(item, "f0"), self.of(item, "mean_diameter")) for item in bearings]
        self._size = self.table(factors) * self.table([torque_size(*pair) for pair in numbers])
        into = [incidence(places, len(self.machine.nodes)) for places in (self._inner, outer)]
        shares = np.swapaxes(share, 1, 2)
        self._into = shares * into[0] + (1.0 - shares) * into[1]

    def heat(
        self, inputs: Inputs, temperatures: FloatArray, states: FloatArray, out: FloatArray
    ) -> None:
        """Add the difference to the heat at constant viscosity."""
        if not self._drivers:
            return
        speed = np.stack([inputs[driver] for driver in self._drivers], axis=-1)
        film = self._thick * np.abs(speed) ** PALMGREN
        thinned = film * np.exp(self._thins * (self._at - temperatures[..., self._inner]))
        change = self._size * (np.maximum(thinned, LEAST) - np.maximum(film, LEAST))
        out += friction_heat(speed, change) @ self._into
