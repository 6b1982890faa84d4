"""Cooling jackets that lose performance during a run."""

from __future__ import annotations

import numpy as np

from plant_model.effects.base import Effect, Inputs
from plant_model.effects.coolant_jacket import flows_of
from plant_model.effects.uneven_cooling import differences_of
from plant_model.exchange import exchange
from plant_model.parameters import FloatArray, Parameter

FILM_EXPONENT = 0.8
"""Exponent of the flow in a turbulent film coefficient [1], given by Dittus and Boelter's law."""


class CoolantDegradation(Effect):
    """Flow V (1 - f) and wall conductance UA (1 - f)^0.8, f = d min(t / t_end, 1) since the start.

    A clogging filter, air in the circuit or a worn pump lowers the flow, and film coefficients of
    turbulent pipe flow vary as about flow^0.8 (Dittus and Boelter's correlation; Gnielinski's in
    VDI Heat Atlas, 2nd ed., part G1). Size and time of the loss are engineering judgement. The
    differences of wall conductance around the circumference fall in the same proportion.
    """

    title = "Cooling that gets worse over the run"
    explanation = "The jackets take away less heat from hour to hour."
    parameters = {
        "loss": Parameter(0.3, "1", 0.0, 0.7, "judgement; of the flow"),
        "hours": Parameter(8.0, "h", 2.0, 24.0, "judgement: a shift to a day"),
    }
    physical = (0.0, 0.98)
    temperature_dependent = True
    states = ("hours_elapsed",)

    def prepare(self) -> None:
        """Collect the walls' conductances as a matrix on the nodes [W/K]."""
        machine, size = self.machine, len(self.machine.nodes)
        self._matrix = np.zeros((self.values.sets, size, size))
        scale = self.scale_of("coolant_jacket")
        walls = [
            exchange(machine, item, scale * self.of(item, "conductance"))
            for item in machine.of_kind("links", "coolant_wall")
        ]
        for wall in [*walls, *differences_of(self)]:
            for node, other in ((wall.node, wall.other), (wall.other, wall.node)):
                self._matrix[:, node, node] += wall.conductance[:, 0]
                self._matrix[:, other, node] -= wall.conductance[:, 0]
        self._flows = flows_of(machine, self.values)

    def start_states(self, temperatures: FloatArray, inputs: Inputs) -> FloatArray:
        """Start the clock."""
        return np.zeros((len(temperatures), 1))

    def rate(self, inputs: Inputs, temperatures: FloatArray, states: FloatArray) -> FloatArray:
        """Count hours."""
        return np.full_like(states, 1.0 / 3600.0)

    def heat(
        self, inputs: Inputs, temperatures: FloatArray, states: FloatArray, out: FloatArray
    ) -> None:
        """Subtract the lost shares of the heat that flows and walls carry."""
        lost = self.own("loss") * np.minimum(states[..., 0] / self.own("hours"), 1.0)
        of_walls = 1.0 - (1.0 - lost) ** FILM_EXPONENT
        out += of_walls[..., None] * (temperatures @ self._matrix)
        for flow in self._flows:
            brought = flow.conductance * flow.warmer(self.machine, inputs, temperatures)
            out[..., flow.node] -= lost * brought
