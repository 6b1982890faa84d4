"""Loss of the built-in motor, proportional to speed."""

from __future__ import annotations

import numpy as np

from plant_model.effects.base import Effect, Inputs, amplitude
from plant_model.item_forms import ItemSpec, NumberSpec
from plant_model.parameters import FloatArray


class MotorLoss(Effect):
    """No-load loss P = k |n|, split between rotor and stator.

    The straight line replaces the losses in the iron and by the drive, a third of them in the
    rotor. Both are engineering judgement, to be replaced by a loss from a data sheet.
    """

    title = "Motor loss"
    explanation = "The motor heats rotor and stator in proportion to speed."
    parameters = {"scale": amplitude(1.0, 0.0, 3.0, "factor on the loss, 1 as given")}
    handles = {
        ("sources", "motor"): ItemSpec(
            refs={"rotor": "node", "stator": "node", "driven_by": "input"},
            numbers={
                "loss": NumberSpec("W/(1000 r/min)", 0.0, 1e4),
                "rotor_share": NumberSpec("1", 0.0, 1.0, 0.33),
            },
            law="loss times speed, without load; rotor_share of it enters the rotor",
        )
    }

    def heat(
        self, inputs: Inputs, temperatures: FloatArray, states: FloatArray, out: FloatArray
    ) -> None:
        """Add every motor's loss to its rotor and stator."""
        for item in self.items:
            speed = np.abs(inputs[item.refs["driven_by"][0]])
            power = self.own("scale") * self.of(item, "loss") * speed * 1e-3
            share = self.of(item, "rotor_share")
            out[..., self.nodes(item, "rotor")[0]] += share * power
            out[..., self.nodes(item, "stator")[0]] += (1.0 - share) * power
