"""Bending of parts that are warmer on one side."""

from __future__ import annotations

import numpy as np

from plant_model.effects.base import POSE, Effect, Inputs, amplitude
from plant_model.item_forms import ItemSpec, NumberSpec
from plant_model.parameters import FloatArray


class HousingBending(Effect):
    """A part with a linear temperature difference across its width bends: phi = alpha dT L / w.

    The part is a free beam with the constant curvature alpha dT / w. The nose turns by phi and
    moves sideways by phi times the distance from the part's middle to the gauge line. ``towards``
    lists the nodes whose warming turns the nose towards the positive axis, ``away`` those on the
    opposite side; ``yaw`` and ``pitch`` give the plane.
    """

    title = "Tilt from one-sided warming"
    explanation = "A part warmer on one side bends and tilts the nose."
    parameters = {"scale": amplitude(1.0, 0.0, 2.0, "factor on the tilt, 1 as given")}
    handles = {
        ("structure", "bend"): ItemSpec(
            refs={"towards": "node*", "away": "node*"},
            numbers={
                "width": NumberSpec("mm", 1.0, 1e4),
                "length": NumberSpec("mm", 0.0, 1e4),
                "lever": NumberSpec("mm", -1e4, 1e4),
                "expansion": NumberSpec("1e-6/K", 0.0, 40.0),
                "yaw": NumberSpec("1", -1.0, 1.0, 0.0),
                "pitch": NumberSpec("1", -1.0, 1.0, 0.0),
            },
            law="tilts by expansion length / width (T_towards - T_away), towards the positive axis "
            "while `towards` is warmer, and moves the nose by tilt times lever",
        )
    }

    def prepare(self) -> None:
        """Collect the pose per kelvin of every node, shape (sets or 1, nodes, 6)."""
        self._weights = np.zeros((self.values.sets, len(self.machine.nodes), len(POSE)))
        for item in self.items:
            # 1e-6/K is also urad/K for a length equal to the width.
            angle = (
                self.own("scale")
                * self.of(item, "expansion")
                * self.of(item, "length")
                / self.of(item, "width")
            )
            sideways = angle * self.of(item, "lever") * 1e-3
            for role, sign in (("towards", 1.0), ("away", -1.0)):
                nodes = self.nodes(item, role)
                for node in nodes:
                    for tilt, shift in (("yaw", "x"), ("pitch", "y")):
                        share = sign * self.of(item, tilt) / len(nodes)
                        self._weights[:, node, POSE.index(tilt)] += (share * angle)[:, 0]
                        self._weights[:, node, POSE.index(shift)] += (share * sideways)[:, 0]

    def displacement(
        self, inputs: Inputs, rise: FloatArray, states: FloatArray, out: FloatArray
    ) -> None:
        """Add the tilt of all parts and the resulting radial drift."""
        out += rise @ self._weights
