"""Conduction through solid parts and joints at constant conductance."""

from __future__ import annotations

from plant_model.effects.base import Effect, amplitude
from plant_model.exchange import exchange
from plant_model.item_forms import ItemSpec, NumberSpec

_FORM = ItemSpec(
    refs={"between": "node,node"},
    numbers={"conductance": NumberSpec("W/K", 0.0, 1e5)},
    law="Q = conductance (Tb - Ta): `conduction` within a part, `contact` through a joint",
)


class Conduction(Effect):
    """Fourier's law between two lumps: Q = G (T_b - T_a), G = k A / L.

    ``conduction`` is a path through one part, ``contact`` one through a joint or a bearing's
    rolling elements. The law is the same; other effects change only ``contact``.
    """

    title = "Conduction through parts and joints"
    explanation = "Heat flows between touching parts in proportion to the difference."
    parameters = {"scale": amplitude(1.0, 0.0, 2.0, "factor on all conduction, 1 as drawn")}
    handles = {
        ("links", "conduction"): _FORM,
        ("links", "contact"): _FORM,
    }

    def prepare(self) -> None:
        """Put the conductances into the constant exchanges."""
        scale = self.own("scale")
        self.constant_exchanges = [
            exchange(self.machine, item, scale * self.of(item, "conductance"))
            for item in self.items
        ]
