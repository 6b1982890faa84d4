"""Convection from outer surfaces to the air at a constant film coefficient."""

from __future__ import annotations

import numpy as np

from plant_model.effects.base import Effect, amplitude
from plant_model.exchange import exchange
from plant_model.item_forms import ItemSpec, NumberSpec
from plant_model.machine import Item
from plant_model.parameters import FloatArray


def held_by_film(effect: Effect, item: Item, coefficient: FloatArray) -> FloatArray:
    """Return the part of a surface's constant film that belongs to another effect [W/(m2 K)].

    Parameters
    ----------
    effect : Effect
        The other effect.
    item : Item
        The surface.
    coefficient : array, shape (sets or 1, 1)
        Film coefficient of the effect at its reference [W/(m2 K)].

    Returns
    -------
    array, shape (sets or 1, 1)
        That coefficient, but at most the film itself.
    """
    film = effect.scale_of("surface_convection") * effect.of(item, "coefficient")
    return np.asarray(np.minimum(coefficient, film))


class SurfaceConvection(Effect):
    """Newton's law of cooling: Q = h A (T_ambient - T), with h constant.

    In still air h is 5 to 12 W/(m2 K) at machine surfaces, of which 2 to 6 are free convection (see
    ``natural_convection``) and 3 to 5 radiation: 4 eps sigma T^3 at room temperature and an
    emissivity of 0.6 to 0.9 (VDI Heat Atlas, 2nd ed., parts F2 and K). Those two effects subtract
    their own part of the film.
    """

    title = "Convection to the air outside"
    explanation = "Outer surfaces lose heat to the air at a constant coefficient."
    parameters = {"scale": amplitude(1.0, 0.0, 4.0, "factor on all film coefficients, 1 as given")}
    handles = {
        ("links", "convection"): ItemSpec(
            refs={"between": "node,boundary"},
            numbers={
                "area": NumberSpec("m2", 0.0, 1e3),
                "coefficient": NumberSpec("W/(m2 K)", 0.0, 1e4),
            },
        )
    }

    def prepare(self) -> None:
        """Put the conductances into the constant exchanges."""
        scale = self.own("scale")
        self.constant_exchanges = [
            exchange(
                self.machine, item, scale * self.of(item, "area") * self.of(item, "coefficient")
            )
            for item in self.items
        ]
