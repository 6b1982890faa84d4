"""A cooler that switches on the spindle's temperature, as the studies' does.

The coolant is one tank through which all jackets' flows go round,

    C dT/dt = sum over jackets of rho c q (T_back - T) - UA (T - T_air) - P while the chiller runs,

and the chiller switches on above one temperature of the spindle and off below another. So the
coolant follows the spindle, and the temperatures go up and down with it.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import pandas as pd

from plant_model.machine import Machine
from plant_model.stepper import PlantStepper

SECONDS_A_MINUTE = 60.0


@dataclass(frozen=True)
class Cooler:
    """A tank and a two-point chiller.

    Attributes
    ----------
    watches : str
        The sensor that switches the chiller.
    on_above, off_below : float
        Where it switches [degC].
    power : float
        What the chiller takes while it runs [W].
    capacity : float
        Heat capacity of the coolant going round [J/K].
    loss : float
        From tank and hoses to the air [W/K].
    heat_capacity : float
        Of the coolant [J/(l K)].
    flows : mapping of str to float
        Flow of each jacket by the sensor at its outlet [l/min].
    """

    watches: str
    on_above: float
    off_below: float
    power: float
    capacity: float
    loss: float
    heat_capacity: float
    flows: Mapping[str, float]

    def inlet(
        self, machine: Machine, inputs: pd.DataFrame, parameters: Mapping[str, float]
    ) -> np.ndarray:
        """Return the coolant's inlet temperature at every row of the inputs, shape (n,) [degC].

        Parameters
        ----------
        machine : Machine
            It is stepped along, so that the cooler knows its temperatures.
        inputs : DataFrame
            ``time_s``, ``speed``, ``ambient``, evenly spaced; the tank starts as warm as the air.
        parameters : mapping of str to float
            Of the machine, instead of its own.
        """
        stepper = PlantStepper(machine, parameters)
        time = inputs["time_s"].to_numpy()
        speed, air = inputs["speed"].to_numpy(), inputs["ambient"].to_numpy()
        step = float(time[1] - time[0])
        carried = {
            name: flow / SECONDS_A_MINUTE * self.heat_capacity for name, flow in self.flows.items()
        }
        tank, runs = float(air[0]), False
        found = np.zeros(len(time))
        for k in range(len(time)):
            found[k] = tank
            given = {"speed": speed[k], "ambient": air[k], "coolant_inlet": tank, "torque": 0.0}
            if k:
                stepper.step(step, given | {"speed": speed[k - 1], "ambient": air[k - 1]})
            else:
                stepper.reset(given)
            read = stepper.outputs()
            watched = read[self.watches]
            runs = watched > self.on_above or (runs and watched > self.off_below)
            back = sum(flow * (read[name] - tank) for name, flow in carried.items())
            heat = back - self.loss * (tank - air[k]) - self.power * runs
            tank += step * heat / self.capacity
        return found
