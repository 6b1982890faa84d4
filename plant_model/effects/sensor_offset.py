"""A thermometer with a constant error."""

from __future__ import annotations

from typing import ClassVar

from plant_model.effects.base import Effect, Inputs
from plant_model.parameters import FloatArray, Parameter


class SensorOffset(Effect):
    """Reading = T + e, the same through the whole run.

    A Pt100 of class B may be off by 0.3 K + 0.005 |t| (IEC 60751). A lead of two wires adds up to
    2 K, a wrong type, a bad contact or a wrong scale tens of kelvin (engineering judgement). It
    does nothing for a displacement sensor, whose zero means nothing.
    """

    name: ClassVar[str] = "sensor_offset"
    title: ClassVar[str] = "Thermometer with a constant error"
    explanation: ClassVar[str] = "One thermometer reads too high or too low by the same amount."
    parameters: ClassVar[dict[str, Parameter]] = {
        "error": Parameter(1.0, "K", -40.0, 40.0, "judgement: faults of tens of kelvin occur")
    }
    amplitude: ClassVar[str] = "error"
    physical: ClassVar[tuple[float, ...]] = (-40.0, 40.0)
    tried: ClassVar[dict[str, tuple[float, ...]]] = {
        "error": (-20.0, -1.0, 1.0, 20.0),
    }
    on_channel: ClassVar[bool] = True
    from_one_run_on: ClassVar[bool] = True

    def error_at_start(self) -> FloatArray:
        """Return the error, which is there from the start."""
        return self.own("error")

    def reading(
        self,
        inputs: Inputs,
        states: FloatArray | None,
        time_s: FloatArray,
        readings: dict[str, FloatArray],
    ) -> None:
        """Add the error."""
        if any(sensor.name == self.channel for sensor in self.machine.sensors):
            readings[self.channel] = readings[self.channel] + self.own("error")
