"""A thermometer with a constant error."""

from __future__ import annotations

from plant_model.effects.base import Effect, Inputs, Readings
from plant_model.parameters import FloatArray, Parameter


class SensorOffset(Effect):
    """Reading = T + e, with the same e during the whole run.

    A Pt100 of class B may be off by 0.3 K + 0.005 |t| (IEC 60751). A two-wire lead adds up to 2 K,
    a wrong type, a bad contact or a wrong scale tens of kelvin (engineering judgement). It does
    nothing to a displacement sensor, whose zero is arbitrary.
    """

    title = "Thermometer with a constant error"
    explanation = "One thermometer reads too high or too low by the same amount."
    parameters = {
        "error": Parameter(1.0, "K", -40.0, 40.0, "judgement: faults of tens of kelvin occur")
    }
    physical = (-40.0, 40.0)
    tried = {
        "error": (-20.0, -1.0, 1.0, 20.0),
    }
    on_channel = True
    from_one_run_on = True

    def reading(
        self, inputs: Inputs, states: FloatArray, time_s: FloatArray, readings: Readings
    ) -> None:
        """Add the error."""
        if any(sensor.name == self.channel for sensor in self.machine.sensors):
            readings[self.channel] = readings[self.channel] + self.own("error")
