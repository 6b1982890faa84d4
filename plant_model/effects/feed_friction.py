"""Friction of a feed axis: screw, nut, guides and motor as one source."""

from __future__ import annotations

import numpy as np

from plant_model.effects.base import Effect, Inputs, amplitude
from plant_model.item_forms import ItemSpec, NumberSpec
from plant_model.parameters import FloatArray


class FeedFriction(Effect):
    """Heat in proportion to the feed rate: P = k |v|, as from a force independent of speed."""

    title = "Feed axis friction"
    explanation = "A moving axis heats its screw and nut in proportion to the feed."
    parameters = {"scale": amplitude(1.0, 0.0, 3.0, "factor on the loss, 1 as given")}
    handles = {
        ("sources", "feed_axis"): ItemSpec(
            refs={"node": "node", "driven_by": "input"},
            numbers={"loss": NumberSpec("W/(m/min)", 0.0, 1e4)},
            law="loss times feed",
        )
    }

    def heat(
        self, inputs: Inputs, temperatures: FloatArray, states: FloatArray, out: FloatArray
    ) -> None:
        """Add each axis's loss to its node."""
        for item in self.items:
            feed = np.abs(inputs[item.refs["driven_by"][0]]) * 1e-3
            out[..., self.nodes(item, "node")[0]] += (
                self.own("scale") * self.of(item, "loss") * feed
            )
