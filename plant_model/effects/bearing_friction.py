"""Palmgren's bearing friction at constant viscosity and preload."""

from __future__ import annotations

import numpy as np

from plant_model.effects.base import Effect, Inputs, amplitude
from plant_model.item_forms import ItemSpec, NumberSpec
from plant_model.machine import Item
from plant_model.parameters import FloatArray

PALMGREN = 2.0 / 3.0
"""Exponent of viscosity times speed in the viscous torque, given by Palmgren [1]."""

LEAST = 160.0
"""That power where viscosity times speed is about 2000 and below, given by Palmgren
[(mm2/s r/min)^(2/3)]."""


def viscous_torque(
    f0: FloatArray, viscosity: FloatArray, speed: FloatArray, diameter: FloatArray
) -> FloatArray:
    """Return Palmgren's load-free torque M0 [N mm].

    Parameters
    ----------
    f0 : array
        Bearing and lubrication factor [1].
    viscosity : array
        Kinematic viscosity of the lubricant at running temperature [mm2/s].
    speed : array
        Shaft speed [r/min].
    diameter : array
        Mean bearing diameter [mm].

    Notes
    -----
    1e-7 f0 (nu n)^(2/3) d^3, and 160e-7 f0 d^3 where that is more. Harris and Kotzalas, Essential
    Concepts of Bearing Technology, 5th ed., ch. 10. At standstill this torque gives no heat.
    """
    film = (viscosity * np.abs(speed)) ** PALMGREN
    return torque_size(f0, diameter) * np.maximum(film, LEAST)


def torque_size(f0: FloatArray, diameter: FloatArray) -> FloatArray:
    """Return the viscous torque over (nu n)^(2/3), from f0 [1] and mean diameters [mm]."""
    return 1e-7 * f0 * diameter**3


def friction_heat(speed: FloatArray, torque: FloatArray) -> FloatArray:
    """Return H = 1.047e-4 n M [W] from speed n [r/min] and torque M [N mm]."""
    return 1.047e-4 * np.abs(speed) * torque


def bearing_heat(effect: Effect, item: Item, speed: FloatArray) -> FloatArray:
    """Return the heat of a bearing set [W] at speeds [r/min], given viscosity and preload."""
    diameter = effect.of(item, "mean_diameter")
    torque = viscous_torque(effect.of(item, "f0"), effect.of(item, "viscosity"), speed, diameter)
    torque = torque + effect.of(item, "f1") * effect.of(item, "preload") * diameter
    factor = effect.scale_of("bearing_friction") * effect.of(item, "count")
    return np.asarray(factor * friction_heat(speed, torque))


def add_to_sides(effect: Effect, item: Item, power: FloatArray, out: FloatArray) -> None:
    """Add a bearing's heat [W] to its inner and outer side."""
    share = effect.of(item, "inner_share")
    out[..., effect.nodes(item, "inner")[0]] += share * power
    out[..., effect.nodes(item, "outer")[0]] += (1.0 - share) * power


class BearingFriction(Effect):
    """Heat of a bearing set: H = 1.047e-4 n z (M0 + M1), M1 = f1 P d.

    The bearing's ``inner_share`` of the heat enters its inner side, the rest its outer side.
    """

    title = "Bearing friction"
    explanation = "Friction in the bearings grows with speed; lubricant and preload stay."
    parameters = {
        "scale": amplitude(1.0, 0.0, 3.0, "factor on Palmgren's torque, range by judgement")
    }
    handles = {
        ("sources", "bearing"): ItemSpec(
            refs={"inner": "node", "outer": "node", "driven_by": "input"},
            numbers={
                "count": NumberSpec("1", 1.0, 20.0, 1.0),
                "mean_diameter": NumberSpec("mm", 5.0, 1e3),
                "f0": NumberSpec("1", 0.1, 20.0),
                "f1": NumberSpec("1", 0.0, 0.01),
                "preload": NumberSpec("N", 0.0, 1e5),
                "viscosity": NumberSpec("mm2/s", 1.0, 1e3),
                "viscosity_at": NumberSpec("degC", -60.0, 200.0, 25.0),
                "inner_share": NumberSpec("1", 0.0, 1.0, 0.5),
            },
            law="H = 1.047e-4 n count (M0 + M1), M1 = f1 preload mean_diameter; inner_share of it "
            "enters the inner node",
        )
    }

    def heat(
        self, inputs: Inputs, temperatures: FloatArray, states: FloatArray, out: FloatArray
    ) -> None:
        """Add every bearing's heat to its two sides."""
        for item in self.items:
            power = bearing_heat(self, item, inputs[item.refs["driven_by"][0]])
            add_to_sides(self, item, power, out)
