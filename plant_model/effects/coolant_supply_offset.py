"""Coolant that arrives at another temperature than its sensor shows."""

from __future__ import annotations

from typing import ClassVar

from plant_model.anatomy import incidence
from plant_model.effects.base import Effect, Inputs
from plant_model.parameters import FloatArray, Parameter


class CoolantSupplyOffset(Effect):
    """Coolant enters every jacket at T_inlet + dT: extra heat V rho c dT per flow.

    A pump that leaves 100 to 600 W in a flow of 5 to 20 l/min warms it by 0.1 to 2 K (water with
    glycol, 3700 J/(l K)), a long line in a colder or warmer hall changes it either way, and the
    sensor has an error of its own. Power and flow are engineering judgement.
    """

    name: ClassVar[str] = "coolant_supply_offset"
    title: ClassVar[str] = "Coolant not at its sensor's temperature"
    explanation: ClassVar[str] = "Pump and line change the coolant between sensor and jackets."
    parameters: ClassVar[dict[str, Parameter]] = {
        "offset": Parameter(0.8, "K", -2.0, 2.0, "judgement: pump power over V rho c")
    }
    amplitude: ClassVar[str] = "offset"

    def prepare(self) -> None:
        """Find the flows that a boundary feeds and what each brings per kelvin [W/K]."""
        boundaries = self.machine.boundary_index
        flows = [
            item
            for item in self.machine.of_kind("links", "coolant_flow")
            if item.refs["between"][1] in boundaries
        ]
        nodes = [self.machine.node_index[item.refs["between"][0]] for item in flows]
        scale = self.own("offset") * self.scale_of("coolant_jacket") / 60.0
        brought = [scale * self.of(item, "flow") * self.of(item, "heat_capacity") for item in flows]
        self._brought = self.table(brought) @ incidence(nodes, len(self.machine.nodes))

    def heat(
        self,
        inputs: Inputs,
        temperatures: FloatArray | None,
        states: FloatArray | None,
        out: FloatArray,
    ) -> None:
        """Add the heat that the offset brings."""
        out += self._brought
