"""Iron loss of the motor, in addition to the loss in force."""

from __future__ import annotations

import numpy as np

from plant_model.effects.base import Effect, Inputs
from plant_model.parameters import FloatArray, Parameter


class MotorIronLoss(Effect):
    """P = P_high ((1 - q) r + q r^2) with r = n / n_high; n_high is the highest speed.

    Hysteresis loss grows with frequency, classical eddy-current loss with its square; the excess
    loss between them is left out (separation of losses: Bertotti, IEEE Trans. Magn. 24 (1988)
    621-630, doi:10.1109/20.43994). Most of the loss arises in the stator. Several motors share it
    equally. The range, up to 1000 W in spindle motors of 10 to 40 kW, and the shares are
    engineering judgement.
    """

    title = "Iron loss of the motor"
    explanation = "Changing magnetisation heats the stator, with speed and with its square."
    parameters = {
        "power": Parameter(300.0, "W", 0.0, 1000.0, "judgement: motors of 10 to 40 kW"),
        "eddy_share": Parameter(0.6, "1", 0.0, 1.0, "judgement: thin sheets at some 100 Hz"),
        "stator_share": Parameter(0.85, "1", 0.6, 1.0, "judgement: the rotor sees slip frequency"),
    }
    law = ("eddy_share",)

    def prepare(self) -> None:
        """Find the motors."""
        self._motors = self.machine.of_kind("sources", "motor")
        self._highest = {e.name: max(e.high, -e.low) for e in self.machine.inputs}

    def heat(
        self, inputs: Inputs, temperatures: FloatArray, states: FloatArray, out: FloatArray
    ) -> None:
        """Add every motor's loss to its stator and rotor."""
        eddy, stator = self.own("eddy_share"), self.own("stator_share")
        for item in self._motors:
            driver = item.refs["driven_by"][0]
            relative = np.abs(inputs[driver]) / self._highest[driver]
            power = self.own("power") * ((1.0 - eddy) * relative + eddy * relative**2)
            power = power / len(self._motors)
            out[..., self.nodes(item, "stator")[0]] += stator * power
            out[..., self.nodes(item, "rotor")[0]] += (1.0 - stator) * power
