"""Heat radiation from outer surfaces."""

from __future__ import annotations

from typing import ClassVar

from plant_model.effects.base import Effect, Inputs
from plant_model.parameters import FloatArray, Parameter

STEFAN_BOLTZMANN = 5.670374419e-8  # W/(m2 K4), CODATA 2018
KELVIN = 273.15


class Radiation(Effect):
    """Grey surfaces facing the hall: Q = eps sigma A (T_ambient^4 - T^4), temperatures in kelvin.

    It acts on every surface that the machine file lists for convection, besides the film
    coefficient given there. Emissivity: 0.2 bare machined steel to 0.9 paint (VDI Heat Atlas,
    2nd ed., part K).
    """

    name: ClassVar[str] = "radiation"
    title: ClassVar[str] = "Radiation from hot surfaces"
    explanation: ClassVar[str] = "Surfaces radiate with the fourth power of temperature."
    parameters: ClassVar[dict[str, Parameter]] = {
        "emissivity": Parameter(0.6, "1", 0.0, 0.95, "VDI Heat Atlas, 2nd ed., part K")
    }
    amplitude: ClassVar[str] = "emissivity"
    physical: ClassVar[tuple[float, ...]] = (0.0, 1.0)
    temperature_dependent: ClassVar[bool] = True

    def prepare(self) -> None:
        """Collect the surfaces."""
        index = self.machine.node_index
        self._surfaces = [
            (index[item.refs["between"][0]], item.refs["between"][1], self.of(item, "area"))
            for item in self.machine.of_kind("links", "convection")
        ]

    def heat(
        self,
        inputs: Inputs,
        temperatures: FloatArray | None,
        states: FloatArray | None,
        out: FloatArray,
    ) -> None:
        """Add what every surface receives."""
        assert temperatures is not None
        factor = self.own("emissivity") * STEFAN_BOLTZMANN
        for node, outside, area in self._surfaces:
            # Squares of squares: a power costs many times as much, and this is asked at every step.
            own = (temperatures[..., node] + KELVIN) * (temperatures[..., node] + KELVIN)
            around = (inputs[outside] + KELVIN) * (inputs[outside] + KELVIN)
            out[..., node] += factor * area * (around * around - own * own)
