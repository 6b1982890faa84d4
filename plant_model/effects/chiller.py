"""A chiller switched on and off by the temperature of a part."""

from __future__ import annotations

import numpy as np

from plant_model.effects.base import Effect, Inputs, amplitude
from plant_model.item_forms import ItemSpec, NumberSpec
from plant_model.parameters import FloatArray


class Chiller(Effect):
    """A node, the tank, loses the power P while another node, the watched part, is too warm.

    The chiller starts when the watched part is warmer than T_on and stops when it is colder than
    T_on - b. It switches at the end of a step, which is 10 s by default. The studies switch their
    cooler by a threshold on the spindle. Circulating coolant is a ``coolant_flow`` from the tank to
    a jacket and another back to the tank.
    """

    title = "Chiller switched by a part's temperature"
    explanation = "A chiller cools its tank from when a part gets too warm until it is cold enough."
    parameters = {"scale": amplitude(1.0, 0.0, 3.0, "factor on its power, 1 as given")}
    temperature_dependent = True
    states = ("runs",)
    settles = True
    handles = {
        ("sources", "chiller"): ItemSpec(
            refs={"cools": "node", "watches": "node"},
            numbers={
                "power": NumberSpec("W", 0.0, 1e5),
                "on_above": NumberSpec("degC", -60.0, 200.0),
                "dead_band": NumberSpec("K", 0.1, 50.0),
            },
            law="takes its power from the tank `cools` while `watches` is too warm",
            only_one="only one chiller can be in a machine",
        )
    }

    def start_states(self, temperatures: FloatArray, inputs: Inputs) -> FloatArray:
        """Start running if the part is too warm, else resting."""
        return self.settled(inputs, temperatures, np.zeros((len(temperatures), 1)))

    def settled(self, inputs: Inputs, temperatures: FloatArray, states: FloatArray) -> FloatArray:
        """Switch if the watched part has left the dead band; 1 runs, 0 rests."""
        for item in self.items:
            watched = temperatures[:, self.nodes(item, "watches")]
            on_above, band = self.of(item, "on_above"), self.of(item, "dead_band")
            rests = np.where(watched < on_above - band, 0.0, states)
            states = np.where(watched > on_above, 1.0, rests)
        return states

    def heat(
        self, inputs: Inputs, temperatures: FloatArray, states: FloatArray, out: FloatArray
    ) -> None:
        """Take the power from the tank while the chiller runs."""
        for item in self.items:
            power = self.own("scale") * self.of(item, "power")
            out[..., self.nodes(item, "cools")[0]] -= power * states[..., 0]
