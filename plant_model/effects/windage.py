"""Air friction in the gaps around the rotating shaft."""

from __future__ import annotations

import numpy as np

from plant_model.anatomy import input_in
from plant_model.effects.base import Effect, Inputs
from plant_model.parameters import FloatArray, Parameter


class Windage(Effect):
    """P = P_high (n / n_high)^3, n_high is the highest speed; half to each side of each gap.

    A rotating cylinder loses C pi rho omega^3 r^4 L / 2 (Bilgen and Boulos, J. Fluids Eng. 95
    (1973) 122-126, doi:10.1115/1.3446944). C falls with Re^-0.2 if the gap is fully turbulent, and
    with Re^-0.5 below a gap Reynolds number of 1e4; this is left out. The gaps (kind ``air_gap``)
    share the power in proportion to area times radius cubed; without gaps, rotor and stator of the
    motors take it. A smooth rotor of 180 mm length in a gap of 0.7 mm loses 20, 40 or 95 W at
    20,000 r/min with a radius of 40, 50 or 65 mm. Slots, end faces and further gaps raise that up
    to three times, by engineering judgement; the range leaves room for a model that loses the heat
    too easily.
    """

    title = "Windage"
    explanation = "Air friction in the gaps heats shaft and housing with the cube of speed."
    parameters = {
        "power": Parameter(120.0, "W", 0.0, 400.0, "judgement: 1 to 3 times a smooth rotor's loss")
    }

    def prepare(self) -> None:
        """Find both sides of every gap and its share of the power."""
        machine = self.machine
        gaps = machine.of_kind("links", "air_gap")
        motors = machine.of_kind("sources", "motor")
        sides = [item.refs["between"] for item in gaps]
        weights = [self.of(item, "area") * self.of(item, "radius") ** 3 for item in gaps]
        if not gaps:
            sides = [(item.refs["rotor"][0], item.refs["stator"][0]) for item in motors]
            weights = [np.ones((1, 1)) for _ in motors]
        total = self.table(weights).sum(axis=-1)
        self._sides = [
            ([machine.node_index[name] for name in pair], weight / total)
            for pair, weight in zip(sides, weights, strict=True)
        ]
        self._speed = input_in(machine, "rpm")

    def heat(
        self, inputs: Inputs, temperatures: FloatArray, states: FloatArray, out: FloatArray
    ) -> None:
        """Add half of each gap's heat to each side."""
        if self._speed is None:
            return
        highest = max(self._speed.high, -self._speed.low)
        power = self.own("power") * (np.abs(inputs[self._speed.name]) / highest) ** 3
        for nodes, share in self._sides:
            for node in nodes:
                out[..., node] += 0.5 * share * power
