"""A thermometer whose error grows."""

from __future__ import annotations

from typing import ClassVar

from plant_model.effects.base import Effect, Inputs
from plant_model.parameters import FloatArray, Parameter


class SensorDrift(Effect):
    """Reading = T + r t, t the time since the run began.

    0.1 to 3 K over a run of 6 to 8 h, as a loosening contact or a wetting lead may cause, is
    engineering judgement; sound sensors drift far less. It does nothing for a displacement sensor.
    """

    name: ClassVar[str] = "sensor_drift"
    title: ClassVar[str] = "Thermometer that drifts"
    explanation: ClassVar[str] = "The error of one thermometer grows from hour to hour."
    parameters: ClassVar[dict[str, Parameter]] = {
        "rate": Parameter(0.15, "K/h", -0.5, 0.5, "judgement: 0.1 to 3 K over a run")
    }
    amplitude: ClassVar[str] = "rate"
    on_channel: ClassVar[bool] = True

    def reading(
        self,
        inputs: Inputs,
        states: FloatArray | None,
        time_s: FloatArray,
        readings: dict[str, FloatArray],
    ) -> None:
        """Add the error reached."""
        if any(sensor.name == self.channel for sensor in self.machine.sensors):
            error = self.own("rate") * time_s / 3600.0
            readings[self.channel] = readings[self.channel] + error
