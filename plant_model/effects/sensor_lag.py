"""A thermometer that lags."""

from __future__ import annotations

import numpy as np

from plant_model.effects.base import Effect, Inputs, Readings
from plant_model.parameters import FloatArray, Parameter


class SensorLag(Effect):
    """Reading y of one thermometer, tau dy/dt = T - y.

    A loose sensor in a thick pocket needs minutes, a clamped one seconds (engineering judgement);
    ASTM E644 and VDI/VDE 3522 describe how to measure it. If tau is below 30 s, the state lags by
    30 s and the reading moves only by tau / 30 s of the way from T to the state. This is the same
    for slow changes, and the reading becomes T as tau goes to zero. It does nothing to a
    displacement sensor. A lag of less than a minute is not a fault: any thermometer has one.
    """

    title = "Thermometer that follows late"
    explanation = "One thermometer lags behind its part whenever that changes."
    parameters = {
        "minutes": Parameter(5.0, "min", 0.0, 20.0, "judgement: sensors loose in their pockets")
    }
    least = 1.0
    on_channel = True
    states = ("reading",)
    lags = True
    shortest_s = 30.0

    def prepare(self) -> None:
        """Find the node or input that the sensor reads."""
        parts = [sensor.of for sensor in self.machine.sensors if sensor.name == self.channel]
        self._of = parts[0] if parts else None
        self._lag_s = 60.0 * self.own("minutes")

    def target(self, inputs: Inputs, temperatures: FloatArray) -> FloatArray:
        """Return the temperature that the sensor reads."""
        read = np.zeros(temperatures.shape[:2])
        if self._of in self.machine.node_index:
            read = temperatures[..., self.machine.node_index[self._of]]
        elif self._of is not None:
            read = read + inputs[self._of]
        return read[..., None]

    def time_constants(self) -> FloatArray:
        """Return the lag, but at least one that error control steps easily."""
        return np.maximum(self._lag_s, self.shortest_s)

    def reading(
        self, inputs: Inputs, states: FloatArray, time_s: FloatArray, readings: Readings
    ) -> None:
        """Show the lagging temperature."""
        if self._of is not None:
            share = np.minimum(self._lag_s / self.shortest_s, 1.0)
            shown = readings[self.channel]
            readings[self.channel] = shown + share * (states[..., 0] - shown)
