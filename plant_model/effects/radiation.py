"""Heat radiation from outer surfaces."""

from __future__ import annotations

import numpy as np

from plant_model.effects.base import Effect, Inputs
from plant_model.effects.surface_convection import Surfaces
from plant_model.parameters import ROOM_DEGC, FloatArray, Parameter

STEFAN_BOLTZMANN = 5.670374419e-8
"""As given by CODATA 2018 [W/(m2 K4)]."""
KELVIN = 273.15
"""0 degC, given by the SI [K]."""


class Radiation(Effect):
    """Grey surfaces facing the hall: Q = A (eps sigma (T_a^4 - T^4) - h_r (T_a - T)), in kelvin.

    It acts on every surface with convection in the machine file. The film coefficient given there
    is for still air *and* radiation, so its radiation part is subtracted: h_r = 4 eps sigma T_0^3
    at T_0 = 20 degC (3.4 W/(m2 K) at 0.6), or the whole film if that is less. With surface and hall
    near 20 degC, the loss is the same as without this effect; it grows by 1 % of h_r per kelvin
    that both are warmer, and by half of that if only one is. Emissivity: 0.2 for bare machined
    steel to 0.9 for paint (VDI Heat Atlas, 2nd ed., part K).
    """

    title = "Radiation from hot surfaces"
    explanation = (
        "Surfaces radiate with the fourth power of temperature; the part that their film "
        "coefficient already includes at 20 degC is not counted twice."
    )
    parameters = {"emissivity": Parameter(0.6, "1", 0.0, 0.95, "VDI Heat Atlas, 2nd ed., part K")}
    physical = (0.0, 1.0)
    temperature_dependent = True

    def prepare(self) -> None:
        """Collect the surfaces."""
        # Film coefficients are assumed to be stated for surface and hall at this temperature.
        at_reference = 4.0 * STEFAN_BOLTZMANN * (ROOM_DEGC + KELVIN) ** 3 * self.own("emissivity")
        self._surfaces = Surfaces(self, at_reference)

    def heat(
        self, inputs: Inputs, temperatures: FloatArray, states: FloatArray, out: FloatArray
    ) -> None:
        """Add the heat that each surface receives in addition to that of its film."""
        self._surfaces.add_heat(self._received, inputs, temperatures, out)

    def _received(self, around: FloatArray, own: FloatArray) -> FloatArray:
        """Return what surfaces receive from the hall [W/m2]."""
        # Squares of squares: a power costs many times as much, and this runs at every step.
        around, own = ((part + KELVIN) * (part + KELVIN) for part in (around, own))
        factor = self.own("emissivity")[..., None] * STEFAN_BOLTZMANN
        return np.asarray(factor * (around * around - own * own))
