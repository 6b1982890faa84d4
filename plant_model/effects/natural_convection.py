"""Free convection of still air along warm surfaces."""

from __future__ import annotations

import numpy as np

from plant_model.effects.base import Effect, Inputs
from plant_model.effects.surface_convection import Surfaces
from plant_model.parameters import FloatArray, Parameter


class NaturalConvection(Effect):
    """Film coefficient h = h1 (|T - T_air| / 10 K)^(1/4) in place of h1 in the constant one.

    A film coefficient of still air already includes free convection. This part is assumed to be
    that at 10 K, or the whole film if that is less, and is subtracted: a surface 10 K warmer than
    the air loses as much as without this effect, a colder one less and a warmer one more.

    Laminar free convection along a plate of height L, 1.42 (dT / L)^(1/4) W/(m2 K) in air, gives
    2.5 to 6 W/(m2 K) at 10 K for 1 to 0.03 m (Holman, Heat Transfer, 10th ed., table 7-2; fuller
    correlations: VDI Heat Atlas, 2nd ed., part F2). The range covers 0 to 8.
    """

    title = "Convection outside growing with temperature"
    explanation = (
        "Warm surfaces make the air rise and lose more heat the warmer they are; the part that "
        "their film coefficient already includes at 10 K is not counted twice."
    )
    parameters = {
        "film_at_10_K": Parameter(4.0, "W/(m2 K)", 0.0, 8.0, "1.42 (dT/L)^(1/4): Holman, table 7-2")
    }
    temperature_dependent = True

    def prepare(self) -> None:
        """Collect the surfaces."""
        self._surfaces = Surfaces(self, self.own("film_at_10_K"))

    def heat(
        self, inputs: Inputs, temperatures: FloatArray, states: FloatArray, out: FloatArray
    ) -> None:
        """Add the heat that each surface receives in addition to that of its film."""
        self._surfaces.add_heat(self._received, inputs, temperatures, out)

    def _received(self, air: FloatArray, own: FloatArray) -> FloatArray:
        """Return what surfaces receive by free convection [W/m2]."""
        grown = np.sqrt(np.sqrt(np.abs(air - own) / 10.0))
        return np.asarray(self.own("film_at_10_K")[..., None] * grown * (air - own))
