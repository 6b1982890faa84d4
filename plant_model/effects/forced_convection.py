"""Convection to air stirred by a rotating spindle."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from plant_model.anatomy import enclosed_air, input_in, spindle_nodes
from plant_model.effects.base import Effect, Inputs
from plant_model.exchange import Exchange, exchange
from plant_model.machine import Machine
from plant_model.parameters import FloatArray, Parameter

OUTSIDE = "outside"
"""The default driver: air of the hall."""


class ForcedConvection(Effect):
    """Film coefficient h = h0 (1 + c (n / n_ref)^0.7); n_ref is the highest speed.

    It acts on the surfaces of the spindle in the hall: shaft, housing, tool, bearings and motor; if
    none of these has a surface in the machine file, on all surfaces. In an enclosure whose air is a
    part (`plant_model.anatomy.enclosed_air`) the driver may choose all contacts of that air
    instead: chuck or tool stir it. The exponent is that of a cylinder rotating in still air: 2/3 in
    Anderson and Saunders, Proc. R. Soc. A 217 (1953) 555-562, and in Kays and Bjorklund, Trans.
    ASME 80 (1958) 70-78; 0.7 in Dropkin and Carmi, Trans. ASME 79 (1957) 741-749. The effect on
    parts that do not rotate, and its size, are engineering judgement.
    """

    title = "Convection outside growing with speed"
    explanation = (
        "The turning spindle stirs the air and cools its own outside, or all that is in its "
        "enclosure; at standstill that stops."
    )
    parameters = {"gain": Parameter(1.5, "1", 0.0, 4.0, "judgement: 5 to 45 W/(m2 K) in all")}
    conductance_inputs = ("speed",)

    @classmethod
    def drivers(cls, machine: Machine) -> dict[str, str]:
        """Return the air that may be stirred: the hall's or an enclosure's."""
        inside = enclosed_air(machine)
        return {OUTSIDE: "the hall's air", inside: f"the air inside ({inside})"} if inside else {}

    def prepare(self) -> None:
        """Find the surfaces and the gain of each, from its conductance at standstill [W/K]."""
        if self.driver in ("", OUTSIDE):
            surfaces = self.machine.of_kind("links", "convection")
            spindle = spindle_nodes(self.machine)
            near = [item for item in surfaces if item.refs["between"][0] in spindle]
            scale = self.own("gain") * self.scale_of("surface_convection")
            self._surfaces = [
                (item, scale * self.of(item, "area") * self.of(item, "coefficient"))
                for item in near or surfaces
            ]
        else:
            contacts = self.machine.of_kind("links", "contact")
            scale = self.own("gain") * self.scale_of("conduction")
            self._surfaces = [
                (item, scale * self.of(item, "conductance"))
                for item in contacts
                if self.driver in item.refs["between"]
            ]
        speed = input_in(self.machine, "rpm")
        self._reference = max(speed.high, -speed.low) if speed else 1.0

    def conductance(
        self, inputs: Inputs, temperatures: FloatArray, states: FloatArray
    ) -> Sequence[Exchange]:
        """Return the exchange added by speed."""
        stirred = (np.abs(inputs["speed"]) / self._reference) ** 0.7
        return [exchange(self.machine, item, g * stirred) for item, g in self._surfaces]
