"""A holding brake that does not let go wholly."""

from __future__ import annotations

import numpy as np

from plant_model.anatomy import input_in
from plant_model.effects.base import Effect, Inputs
from plant_model.parameters import FloatArray, Parameter


class BrakeDrag(Effect):
    """P = P_high |n| / n_high into the rotors of the motors: a constant torque drags."""

    title = "Dragging brake"
    explanation = "A brake that drags heats the rotor in proportion to speed."
    parameters = {
        "power": Parameter(80.0, "W", 0.0, 300.0, "judgement: 0.1 Nm at 10,000 r/min is 105 W")
    }

    def prepare(self) -> None:
        """Find the rotors and the speed."""
        motors = self.machine.of_kind("sources", "motor")
        self._rotors = [node for item in motors for node in self.nodes(item, "rotor")]
        self._speed = input_in(self.machine, "rpm")

    def heat(
        self, inputs: Inputs, temperatures: FloatArray, states: FloatArray, out: FloatArray
    ) -> None:
        """Share the heat among the rotors."""
        if self._speed is None:
            return
        highest = max(self._speed.high, -self._speed.low)
        power = self.own("power") * np.abs(inputs[self._speed.name]) / highest
        for node in self._rotors:
            out[..., node] += power / len(self._rotors)
