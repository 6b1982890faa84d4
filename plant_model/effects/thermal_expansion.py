"""Growth of shaft, housing, supporting parts and tool, and the resulting motion of the nose."""

from __future__ import annotations

import numpy as np

from plant_model.effects.base import POSE, Effect, Inputs, amplitude
from plant_model.item_forms import ItemSpec, NumberSpec
from plant_model.machine import Item
from plant_model.parameters import FloatArray

_SEGMENT = ItemSpec(
    refs={"nodes": "node*"},
    numbers={
        "start": NumberSpec("mm", -1e4, 1e4),
        "end": NumberSpec("mm", -1e4, 1e4),
        "expansion": NumberSpec("1e-6/K", 0.0, 40.0),
    },
    law="grows in length: the housing counts from its face to the locating bearing, the shaft from "
    "there to the gauge line",
)


def located(effect: Effect) -> tuple[FloatArray, FloatArray]:
    """Return where the bearing holds the shaft, and the gauge line [mm], each (sets or 1, 1)."""
    item = effect.machine.of_kind("structure", "located")[0]
    return effect.of(item, "at"), effect.of(item, "gauge_line")


def stretch(
    effect: Effect, item: Item, first: FloatArray, last: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return a segment's length from one place to another, and the middle of that part [mm].

    Parameters
    ----------
    effect : Effect
    item : Item
        With ``start`` and ``end``.
    first, last : array, shape (sets or 1, 1)
        Places along the axis; the length is negative if the way leads to the rear.
    """
    start = np.maximum(effect.of(item, "start"), np.minimum(first, last))
    end = np.minimum(effect.of(item, "end"), np.maximum(first, last))
    length = np.sign(last - first) * np.maximum(end - start, 0.0)
    return np.asarray(length), np.asarray((start + end) / 2.0)


class ThermalExpansion(Effect):
    """Axial and radial growth: dL = alpha L (T - T_start), summed along the path to the nose.

    Positions count from the mounting face of the housing towards the nose. The path follows the
    housing from the face to the locating bearing, and from there the shaft to the gauge line; the
    other bearing floats and moves nothing. ``member`` is any further part that carries the spindle,
    with its direction; ``tool`` is the tool or test bar beyond the gauge line.
    """

    title = "Thermal expansion"
    explanation = "Parts grow in proportion to their warming, from the locating bearing."
    parameters = {"scale": amplitude(1.0, 0.0, 1.5, "factor on all growth, 1 as given")}
    handles = {
        ("structure", "housing"): _SEGMENT,
        ("structure", "shaft"): _SEGMENT,
        ("structure", "located"): ItemSpec(
            refs={},
            numbers={"at": NumberSpec("mm", -1e4, 1e4), "gauge_line": NumberSpec("mm", -1e4, 1e4)},
            law="where the bearing sits that holds the shaft; from the housing's face",
            only_one="only one bearing can locate the shaft",
        ),
        ("structure", "member"): ItemSpec(
            refs={"nodes": "node*"},
            numbers={
                "length": NumberSpec("mm", 0.0, 1e4),
                "expansion": NumberSpec("1e-6/K", 0.0, 40.0),
                "x": NumberSpec("1", -1.0, 1.0, 0.0),
                "y": NumberSpec("1", -1.0, 1.0, 0.0),
                "elongation": NumberSpec("1", -1.0, 1.0, 0.0),
            },
            law="moves the nose by expansion length along x, y and elongation, each its share",
        ),
        ("structure", "tool"): ItemSpec(
            refs={"nodes": "node*"},
            numbers={"expansion": NumberSpec("1e-6/K", 0.0, 40.0)},
            law="grows beyond the gauge line, by its length in use",
        ),
    }

    def prepare(self) -> None:
        """Collect the pose per kelvin of every node, shape (sets or 1, nodes, 6)."""
        self._weights = np.zeros((self.values.sets, len(self.machine.nodes), len(POSE)))
        for item in self.items:
            if item.kind in {"housing", "shaft"}:
                self._add(item, "elongation", self._length_in_path(item))
            elif item.kind == "member":
                for axis in ("x", "y", "elongation"):
                    self._add(item, axis, self.of(item, "length") * self.of(item, axis))
            elif item.kind == "tool":
                self._add(item, "tool_strain", np.ones((1, 1)))

    def _length_in_path(self, item: Item) -> FloatArray:
        """Return the signed length [mm] of a segment in the path to the nose."""
        bearing, gauge = located(self)
        if item.kind == "housing":
            return stretch(self, item, 0.0 * bearing, bearing)[0]
        return stretch(self, item, bearing, gauge)[0]

    def _add(self, item: Item, axis: str, length: FloatArray) -> None:
        # 1e-6/K times mm is nm/K; a thousandth of that is um/K.
        growth = self.own("scale") * self.of(item, "expansion") * length * 1e-3
        nodes = self.nodes(item, "nodes")
        for node in nodes:
            self._weights[:, node, POSE.index(axis)] += growth[:, 0] / len(nodes)

    def displacement(
        self, inputs: Inputs, rise: FloatArray, states: FloatArray, out: FloatArray
    ) -> None:
        """Add the growth of all parts."""
        out += rise @ self._weights
