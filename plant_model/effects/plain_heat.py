"""Heat in a part without a specific law: constant, or driven by an input."""

from __future__ import annotations

import numpy as np

from plant_model.effects.base import Effect, Inputs, amplitude
from plant_model.item_forms import ItemSpec, NumberSpec
from plant_model.parameters import FloatArray


class PlainHeat(Effect):
    """Heat in one node: P, or P (|u| / u_high)^a with an input u, of at most u_high.

    ``steady_heat`` is on whenever the machine is on: a cabinet, a pump, hydraulics, a drive that
    holds its axis; some 10 to 500 W for a machine in standby (ISO 14955-1:2017, annex A, lists what
    is on in that state). ``driven_heat`` depends on an input, in a part of which no more is known:
    a = 1 for friction that does not depend on speed, 2 for viscous friction. u_high is the largest
    absolute value of the input's range.
    """

    title = "Additional heat source in a part"
    explanation = "A part is heated constantly, or in proportion to a power of an input."
    parameters = {"scale": amplitude(1.0, 0.0, 3.0, "factor on all of it, 1 as given")}
    handles = {
        ("sources", "steady_heat"): ItemSpec(
            refs={"node": "node"},
            numbers={"power": NumberSpec("W", 0.0, 1e5)},
            law="on whenever the machine is on",
        ),
        ("sources", "driven_heat"): ItemSpec(
            refs={"node": "node", "driven_by": "input"},
            numbers={
                "power": NumberSpec("W", 0.0, 1e5),
                "exponent": NumberSpec("1", 0.5, 3.0, 1.0),
            },
            law="power (|u| / u_high)^exponent, u_high the largest value of its range",
        ),
    }

    def prepare(self) -> None:
        """Find the largest value of each input."""
        self._most = {entry.name: entry.most for entry in self.machine.inputs}

    def heat(
        self, inputs: Inputs, temperatures: FloatArray, states: FloatArray, out: FloatArray
    ) -> None:
        """Add every source to its node."""
        for item in self.items:
            power = self.own("scale") * self.of(item, "power")
            if item.kind == "driven_heat":
                (driver,) = item.refs["driven_by"]
                share = np.abs(inputs[driver]) / self._most[driver]
                power = power * share ** self.of(item, "exponent")
            out[..., self.nodes(item, "node")[0]] += power
