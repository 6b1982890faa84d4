"""Bending of parts that are warmer on one side."""

from __future__ import annotations

import numpy as np

from plant_model.effects.base import POSE, Effect, Inputs, amplitude
from plant_model.effects.thermal_expansion import located, stretch
from plant_model.item_forms import ItemSpec, NumberSpec
from plant_model.machine import Item
from plant_model.parameters import FloatArray

_SIDES = {"towards": "node*", "away": "node*"}
_ACROSS = {
    "width": NumberSpec("mm", 1.0, 1e4),
    "expansion": NumberSpec("1e-6/K", 0.0, 40.0),
    "yaw": NumberSpec("1", -1.0, 1.0, 0.0),
    "pitch": NumberSpec("1", -1.0, 1.0, 0.0),
}


class HousingBending(Effect):
    """A part with a linear temperature difference across its width bends: phi = alpha dT L / w.

    The part is a free beam with the constant curvature alpha dT / w. The nose turns by phi and
    moves sideways by phi times the distance from the part's middle to the gauge line. ``towards``
    lists the nodes whose warming turns the nose towards the positive axis, ``away`` those on the
    opposite side; ``yaw`` and ``pitch`` give the plane.

    A ``ring`` of the housing bends between the mounting face and the locating bearing, and turns
    the nose the other way if that bearing is behind the face.
    """

    title = "Tilt from one-sided warming"
    explanation = "A part warmer on one side bends and tilts the nose."
    parameters = {"scale": amplitude(1.0, 0.0, 2.0, "factor on the tilt, 1 as given")}
    handles = {
        ("structure", "bend"): ItemSpec(
            refs=_SIDES,
            numbers={
                "length": NumberSpec("mm", 0.0, 1e4),
                "lever": NumberSpec("mm", -1e4, 1e4),
                **_ACROSS,
            },
            law="tilts by expansion length / width (T_towards - T_away), towards the positive axis "
            "while `towards` is warmer, and moves the nose by tilt times lever",
        ),
        ("structure", "ring"): ItemSpec(
            refs=_SIDES,
            numbers={
                "start": NumberSpec("mm", -1e4, 1e4),
                "end": NumberSpec("mm", -1e4, 1e4),
                **_ACROSS,
            },
            law="the same, by its length between the housing's face and the locating bearing; "
            "reversed if that bearing is behind the face",
        ),
    }

    def prepare(self) -> None:
        """Collect the pose per kelvin of every node, shape (sets or 1, nodes, 6)."""
        self._weights = np.zeros((self.values.sets, len(self.machine.nodes), len(POSE)))
        for item in self.items:
            length, lever = self._length_and_lever(item)
            # 1e-6/K is also urad/K for a length equal to the width.
            angle = self.own("scale") * self.of(item, "expansion") * length / self.of(item, "width")
            sideways = angle * lever * 1e-3
            for role, sign in (("towards", 1.0), ("away", -1.0)):
                nodes = self.nodes(item, role)
                for node in nodes:
                    for tilt, shift in (("yaw", "x"), ("pitch", "y")):
                        share = sign * self.of(item, tilt) / len(nodes)
                        self._weights[:, node, POSE.index(tilt)] += (share * angle)[:, 0]
                        self._weights[:, node, POSE.index(shift)] += (share * sideways)[:, 0]

    def _length_and_lever(self, item: Item) -> tuple[FloatArray, FloatArray]:
        """Return the signed length that bends and its middle's distance to the gauge line [mm]."""
        if item.kind == "bend":
            return self.of(item, "length"), self.of(item, "lever")
        bearing, gauge = located(self)
        length, middle = stretch(self, item, 0.0 * bearing, bearing)
        return length, gauge - middle

    def displacement(
        self, inputs: Inputs, rise: FloatArray, states: FloatArray, out: FloatArray
    ) -> None:
        """Add the tilt of all parts and the resulting radial drift."""
        out += rise @ self._weights
