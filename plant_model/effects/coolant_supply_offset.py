"""Coolant that arrives at a different temperature than its sensor shows."""

from __future__ import annotations

from plant_model.effects.base import Effect, Inputs
from plant_model.effects.coolant_jacket import carried_from_inlets
from plant_model.parameters import FloatArray, Parameter


class CoolantSupplyOffset(Effect):
    """Coolant enters every jacket at T_inlet + dT: extra heat V rho c dT per flow.

    A pump that puts 100 to 600 W into a flow of 5 to 20 l/min warms it by 0.1 to 2 K (water with
    glycol, 3700 J/(l K)), a long line in a colder or warmer hall cools or warms it, and the sensor
    has its own error. Power and flow are engineering judgement.
    """

    title = "Coolant not at its sensor's temperature"
    explanation = "Pump and line change the coolant between sensor and jackets."
    parameters = {"offset": Parameter(0.8, "K", -2.0, 2.0, "judgement: pump power over V rho c")}

    def prepare(self) -> None:
        """Compute the heat from the offset into every node [W]."""
        self._brought = carried_from_inlets(self, self.own("offset"))

    def heat(
        self, inputs: Inputs, temperatures: FloatArray, states: FloatArray, out: FloatArray
    ) -> None:
        """Add the heat from the offset."""
        out += self._brought
