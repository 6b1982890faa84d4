"""Convection from outer surfaces to the air at a constant film coefficient."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from plant_model.anatomy import incidence
from plant_model.effects.base import Effect, Inputs, amplitude
from plant_model.exchange import exchange
from plant_model.item_forms import ItemSpec, NumberSpec
from plant_model.parameters import FloatArray


class Surfaces:
    """All surfaces with a constant film, part of which belongs to another effect.

    Parameters
    ----------
    effect : Effect
        The other effect.
    coefficient : array, shape (sets or 1, 1)
        Its film coefficient at its reference; at most the film itself is its own [W/(m2 K)].
    """

    def __init__(self, effect: Effect, coefficient: FloatArray) -> None:
        surfaces = effect.machine.of_kind("links", "convection")
        scale = effect.scale_of("surface_convection")
        index = effect.machine.node_index
        self._nodes = [index[item.refs["between"][0]] for item in surfaces]
        outside = [item.refs["between"][1] for item in surfaces]
        self._outside = list(dict.fromkeys(outside))
        self._air = [self._outside.index(name) for name in outside]
        self._areas = effect.table([effect.of(item, "area") for item in surfaces])
        films = [scale * effect.of(item, "coefficient") for item in surfaces]
        self._held = np.minimum(coefficient[..., None], effect.table(films))
        self._to_nodes = incidence(self._nodes, len(index))

    def add_heat(
        self,
        law: Callable[[FloatArray, FloatArray], FloatArray],
        inputs: Inputs,
        temperatures: FloatArray,
        out: FloatArray,
    ) -> None:
        """Add the heat that each surface receives in addition to that of its film.

        Parameters
        ----------
        law : callable
            Takes the temperatures of the air (times, surfaces) and of the surfaces (sets, times,
            surfaces) [degC]; returns the heat that these receive by the other effect [W/m2].
        inputs, temperatures, out
            As for `Effect.heat`.
        """
        if not self._outside:
            return
        air = np.stack([inputs[name] for name in self._outside], axis=-1)[..., self._air]
        own = temperatures[..., self._nodes]
        out += ((law(air, own) - self._held * (air - own)) * self._areas) @ self._to_nodes


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
            law="Q = coefficient area (Tb - Ta): a film, radiation included",
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
