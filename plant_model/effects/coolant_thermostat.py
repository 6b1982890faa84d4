"""A chiller that switches its cooling on and off."""

from __future__ import annotations

from typing import ClassVar

import numpy as np

from plant_model.effects.base import Effect, Inputs
from plant_model.effects.coolant_jacket import carried_from_inlets
from plant_model.parameters import FloatArray, Parameter


class CoolantThermostat(Effect):
    """What reaches the jackets swings by +-b around the inlet's reading, between dead-band limits.

    dT = b y climbs while the compressor rests and falls while it runs, at the same even rate: y
    goes from -1 to 1 and back in a period p. Where in its cycle a run begins is a parameter.
    Two-point chillers keep +-0.5 to 2 K, and switch no more than some ten times an hour to spare
    the compressor (engineering judgement; see the chiller's data sheet). It acts on every flow that
    a boundary feeds.
    """

    name: ClassVar[str] = "coolant_thermostat"
    title: ClassVar[str] = "Chiller switching on and off"
    explanation: ClassVar[str] = (
        "The chiller's dead band makes the coolant's temperature swing, whatever the spindle does."
    )
    parameters: ClassVar[dict[str, Parameter]] = {
        "band": Parameter(0.6, "K", 0.0, 1.5, "judgement: two-point chillers keep +-0.5 to 2 K"),
        "period": Parameter(15.0, "min", 5.0, 40.0, "judgement: up to some ten switchings an hour"),
        "phase": Parameter(0.0, "1", 0.0, 1.0, "any; 0 is the coldest instant"),
    }
    amplitude: ClassVar[str] = "band"
    temperature_dependent: ClassVar[bool] = True
    swings: ClassVar[tuple[str, ...]] = ("period", "phase")
    states: ClassVar[tuple[str, ...]] = ("cycle",)
    state_scales: ClassVar[tuple[float, ...]] = (100.0,)

    def prepare(self) -> None:
        """Compute what the flows that a boundary feeds bring into every node [W/K]."""
        self._carried = carried_from_inlets(self, np.ones((1, 1)))
        self._period_s = 60.0 * self.own("period")

    def start_states(self, temperatures: FloatArray, inputs: Inputs) -> FloatArray:
        """Start at the phase given."""
        return np.broadcast_to(self.own("phase"), (len(temperatures), 1))

    def rate(self, inputs: Inputs, temperatures: FloatArray, states: FloatArray) -> FloatArray:
        """Return how fast the cycle passes."""
        return np.broadcast_to(1.0 / self._period_s[..., None], states.shape)

    def heat(
        self,
        inputs: Inputs,
        temperatures: FloatArray | None,
        states: FloatArray | None,
        out: FloatArray,
    ) -> None:
        """Add what the warmer or colder coolant brings."""
        assert states is not None
        swing = 1.0 - 4.0 * np.abs(states[..., 0] % 1.0 - 0.5)
        out += (self.own("band") * swing)[..., None] * self._carried
