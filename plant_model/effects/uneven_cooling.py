"""Cooling that differs around the circumference, so that the housing bends."""

from __future__ import annotations

from collections import defaultdict

import numpy as np

from plant_model.effects.base import Effect, amplitude
from plant_model.exchange import Exchange, exchange
from plant_model.item_forms import ItemSpec, NumberSpec
from plant_model.parameters import FloatArray


def differences_of(effect: Effect) -> list[Exchange]:
    """Return by how much more the wall of each uneven sector exchanges than the mean wall.

    Parameters
    ----------
    effect : Effect
        Any effect of the machine.
    """
    machine, jacket = effect.machine, effect.scale_of("coolant_jacket")
    left: dict[frozenset[str], FloatArray] = defaultdict(lambda: np.zeros((1, 1)))
    for item in machine.of_kind("links", "coolant_wall"):
        wall = frozenset(item.refs["between"])
        left[wall] = left[wall] + jacket * effect.of(item, "conductance")
    scale = effect.scale_of("uneven_cooling") * jacket
    exchanges = []
    for item in machine.of_kind("links", "coolant_unevenness"):
        wall = frozenset(item.refs["between"])
        g = scale * effect.of(item, "difference")
        g = np.minimum(np.maximum(g, -left[wall]), left[wall])
        left[wall] = left[wall] + g
        exchanges.append(exchange(machine, item, g))
    return exchanges


class UnevenCooling(Effect):
    """Excess or deficit of a sector's wall conductance: Q = s dUA (T_jacket - T_wall).

    The inlet side of a jacket cools better than the far side. ``coolant_unevenness`` gives a
    sector's difference from the mean; the differences of one ring should sum to zero. A deficit is
    at most all of the sector's ``coolant_wall``, and so is an excess, which a deficit elsewhere
    balances. Without ``coolant_jacket`` there is no cooling, and this effect does nothing.
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
            law="what a sector's wall conducts more than the mean; they add up to 0 around a ring",
        )
    }

    def prepare(self) -> None:
        """Put the conductances into the constant exchanges."""
        self.constant_exchanges = differences_of(self)
