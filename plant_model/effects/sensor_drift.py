"""A thermometer whose error grows."""

from __future__ import annotations

from plant_model.effects.base import Effect, Inputs, Readings
from plant_model.parameters import FloatArray, Parameter


class SensorDrift(Effect):
    """Reading = T + r t; t is the time since the start of the run.

    A loosening contact or a wet lead may cause 0.1 to 3 K over a run of 6 to 8 h (engineering
    judgement); sound sensors drift far less. It does nothing to a displacement sensor.
    """

    title = "Thermometer that drifts"
    explanation = "The error of one thermometer grows from hour to hour."
    parameters = {"rate": Parameter(0.15, "K/h", -0.5, 0.5, "judgement: 0.1 to 3 K over a run")}
    on_channel = True

    def reading(
        self, inputs: Inputs, states: FloatArray, time_s: FloatArray, readings: Readings
    ) -> None:
        """Add the error at each time."""
        if any(sensor.name == self.channel for sensor in self.machine.sensors):
            error = self.own("rate") * time_s / 3600.0
            readings[self.channel] = readings[self.channel] + error
