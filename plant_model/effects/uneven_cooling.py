"""Cooling that differs around the circumference, so that the housing bends."""

from __future__ import annotations

from plant_model.effects.base import Effect, amplitude
from plant_model.exchange import exchange
from plant_model.item_forms import ItemSpec, NumberSpec


class UnevenCooling(Effect):
    """Excess or deficit of a sector's wall conductance: Q = s dUA (T_jacket - T_wall).

    The inlet side of a jacket cools better than the far side. ``coolant_unevenness`` gives a
    sector's difference from the mean; the differences of one ring should sum to zero. Without
    ``coolant_jacket`` there is no cooling, and this effect does nothing.
    """

    title = "Uneven cooling around the circumference"
    explanation = "The jacket cools one side better than the other, which tilts the nose."
    parameters = {
        "scale": amplitude(1.0, 0.0, 1.5, "1 as given by the sectors, 0 for even cooling")
    }
    handles = {
        ("links", "coolant_unevenness"): ItemSpec(
            refs={"between": "node,node"},
            numbers={"difference": NumberSpec("W/K", -1e4, 1e4)},
        )
    }

    def prepare(self) -> None:
        """Put the conductances into the constant exchanges."""
        scale = self.own("scale") * self.scale_of("coolant_jacket")
        self.constant_exchanges = [
            exchange(self.machine, item, scale * self.of(item, "difference")) for item in self.items
        ]
