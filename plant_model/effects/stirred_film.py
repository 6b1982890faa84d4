"""Exchange that grows with motion: a moving axis cools its nut, a rotating pulley its cover."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from plant_model.effects.base import Effect, Inputs, amplitude
from plant_model.exchange import Exchange, exchange
from plant_model.item_forms import ItemSpec, NumberSpec
from plant_model.parameters import FloatArray


def share_of_motion(value: FloatArray, most: float) -> FloatArray:
    """Return the share of a stirred film's highest exchange at a value of its input [1].

    Parameters
    ----------
    value : array
        Value of the input, in its unit.
    most : float
        Largest absolute value of the input's range.
    """
    return np.asarray((np.abs(value) / most) ** 0.7)


class StirredFilm(Effect):
    """Exchange in motion only: Q = G (|u| / u_high)^0.7 (T_b - T_a).

    u is an input, u_high the largest absolute value of its range. It is added to the link that the
    same parts have at rest. The exponent is that of films on rotating and moving surfaces, as in
    ``forced_convection``.
    """

    title = "Exchange that grows with motion"
    explanation = "Parts exchange more heat while the spindle or an axis moves."
    parameters = {"scale": amplitude(1.0, 0.0, 3.0, "factor on all of it, 1 as given")}
    handles = {
        ("links", "stirred"): ItemSpec(
            refs={"between": "node,node|boundary", "driven_by": "input"},
            numbers={"conductance": NumberSpec("W/K", 0.0, 1e5)},
            law="Q = conductance (|u| / u_high)^0.7 (Tb - Ta), u_high the largest value of its "
            "range; in addition to the link at rest",
        )
    }

    def prepare(self) -> None:
        """Find the inputs that drive the links, and the largest value of each."""
        drivers = {item.refs["driven_by"][0] for item in self.items}
        self.conductance_inputs = tuple(sorted(drivers))
        self._most = {entry.name: entry.most for entry in self.machine.inputs}

    def conductance(
        self, inputs: Inputs, temperatures: FloatArray, states: FloatArray
    ) -> Sequence[Exchange]:
        """Return the exchange added by motion."""
        exchanges = []
        for item in self.items:
            (driver,) = item.refs["driven_by"]
            share = share_of_motion(inputs[driver], self._most[driver])
            g = self.own("scale") * self.of(item, "conductance") * share
            exchanges.append(exchange(self.machine, item, g))
        return exchanges
