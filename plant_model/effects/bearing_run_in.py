"""Bearings that turn hard until their grease is spread."""

from __future__ import annotations

from typing import ClassVar

import numpy as np

from plant_model.anatomy import bearings
from plant_model.effects.base import Effect, Inputs
from plant_model.effects.bearing_friction import add_to_sides, bearing_heat
from plant_model.parameters import FloatArray, Parameter


class BearingRunIn(Effect):
    """Friction times 1 + a exp(-t / tau), t the hours turned since the start of the run.

    Grease churns until it is spread evenly, and torque and temperature are high meanwhile (Lugt,
    Grease Lubrication in Rolling Bearings, Wiley 2013, doi:10.1002/9781118483961; Chatra, Osara and
    Lugt, Tribol. Int. (2023) 108375). NSK's run-in of new preloaded bearings takes up to 10 h in
    all (Tech Talk 06, Protect your bearing investment), so tau is seldom above 3 h; the range
    reaches wider. The size of the excess is engineering judgement. Hours at standstill do not
    count. The excess is the same share of Palmgren's heat at every speed, viscosity and preload as
    given.
    """

    name: ClassVar[str] = "bearing_run_in"
    title: ClassVar[str] = "Bearings running in"
    explanation: ClassVar[str] = (
        "Friction is higher in the first hours and falls with the hours that the bearings turned."
    )
    parameters: ClassVar[dict[str, Parameter]] = {
        "excess": Parameter(0.6, "1", 0.0, 2.0, "judgement; that grease churns: Lugt 2013"),
        "hours": Parameter(2.5, "h", 0.5, 10.0, "run-in of up to 10 h in all: NSK Tech Talk 06"),
    }
    amplitude: ClassVar[str] = "excess"
    law: ClassVar[tuple[str, ...]] = ("hours",)
    temperature_dependent: ClassVar[bool] = True
    needs: ClassVar[tuple[str, ...]] = ("bearing_friction",)
    states: ClassVar[tuple[str, ...]] = ("hours_turned",)

    def prepare(self) -> None:
        """Find the bearings."""
        self._bearings = [(item, item.refs["driven_by"][0]) for item in bearings(self.machine)]

    def start_states(self, temperatures: FloatArray, inputs: Inputs) -> FloatArray:
        """Start with no hour turned."""
        return np.zeros((len(temperatures), 1))

    def rate(self, inputs: Inputs, temperatures: FloatArray, states: FloatArray) -> FloatArray:
        """Count the hours in which any bearing turns."""
        turning = np.zeros(states.shape)
        for _, driver in self._bearings:
            turning[..., 0] = np.maximum(turning[..., 0], inputs[driver] != 0.0)
        return turning / 3600.0

    def heat(
        self,
        inputs: Inputs,
        temperatures: FloatArray | None,
        states: FloatArray | None,
        out: FloatArray,
    ) -> None:
        """Add the excess to every bearing's heat."""
        assert states is not None
        excess = self.own("excess") * np.exp(-states[..., 0] / self.own("hours"))
        for item, driver in self._bearings:
            add_to_sides(self, item, excess * bearing_heat(self, item, inputs[driver]), out)
