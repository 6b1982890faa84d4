"""Loss in the motor winding under load."""

from __future__ import annotations

from plant_model.anatomy import input_in
from plant_model.effects.base import Effect, Inputs
from plant_model.parameters import FloatArray, Parameter


class CopperLoss(Effect):
    """P = P_ref (M / M_ref)^2 (1 + 0.0039 (T_stator - 20)), M_ref a tenth of the highest torque.

    Current is proportional to torque, loss to its square, and the resistance of copper rises by
    0.39 % per kelvin (IEC 60034-1: in proportion to 235 + T, 1 / (235 + 20) per kelvin). It does
    nothing on a machine without an input in Nm or without a motor; several motors share it equally.
    The range is for spindle motors of 10 to 40 kW in light to heavy cutting, by engineering
    judgement.
    """

    title = "Copper loss of the motor"
    explanation = "Under load the winding heats the stator with the square of torque."
    parameters = {
        "power": Parameter(
            150.0, "W", 0.0, 2000.0, "judgement: 1 to 3 % of a spindle motor's power, overloads"
        )
    }
    temperature_dependent = True
    per_kelvin = 1.0 / 255.0

    def prepare(self) -> None:
        """Find the stators."""
        motors = self.machine.of_kind("sources", "motor")
        self._stators = [self.nodes(item, "stator")[0] for item in motors]
        self._torque = input_in(self.machine, "Nm")

    def heat(
        self, inputs: Inputs, temperatures: FloatArray, states: FloatArray, out: FloatArray
    ) -> None:
        """Add every winding's loss to its stator."""
        if self._torque is None:
            return
        reference = 0.1 * max(self._torque.high, -self._torque.low)
        load = (inputs[self._torque.name] / reference) ** 2
        for stator in self._stators:
            warm = 1.0 + self.per_kelvin * (temperatures[..., stator] - 20.0)
            out[..., stator] += self.own("power") * load * warm / len(self._stators)
