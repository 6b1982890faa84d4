"""A measuring fixture that moves as it warms."""

from __future__ import annotations

import numpy as np

from plant_model.anatomy import foremost, outside, structure_parts
from plant_model.effects.base import ROUND, Effect, Inputs, Readings
from plant_model.machine import Machine
from plant_model.parameters import FloatArray, Parameter


class FixtureWarming(Effect):
    """All radial readings move by k y together, tau dy/dt = (1 - s) dT_hall + s dT_part - y.

    dT counts from the start of the run. The part is the front of the housing above the fixture or,
    with another driver, the part that the fixture stands on: the column or the part it carries. A
    bracket that holds probes 50 to 450 mm from its clamp moves them by 0.5 to 5 um/K (steel and
    aluminium, 11.5 to 23e-6/K); the lengths are engineering judgement. ISO 230-3 measures the drift
    of spindles with probes in such a fixture. The spindle does not move: only readings change, and
    no tilt appears.
    """

    title = "Measuring fixture warming"
    explanation = "The fixture grows and moves all radial probes alike, though the spindle stays."
    parameters = {
        "growth": Parameter(2.0, "um/K", 0.0, 6.0, "50 to 450 mm of steel or aluminium"),
        "minutes": Parameter(30.0, "min", 5.0, 120.0, "5 to 30 mm of steel in still air"),
        "nose_share": Parameter(0.3, "1", 0.0, 1.0, "judgement: how near the part it stands"),
        "direction": Parameter(45.0, "deg", -180.0, 180.0, "0 moves X readings, 90 Y readings"),
    }
    law = ("minutes",)
    tried = {
        "growth": (2.0,),
        "minutes": (8.0, 25.0, 80.0),
        "nose_share": (0.0, 0.3, 1.0),
        "direction": ROUND,
    }
    states = ("fixture", "at_start")
    lags = True

    @classmethod
    def drivers(cls, machine: Machine) -> dict[str, str]:
        """Return the parts that may warm the fixture with the hall, the housing's nose first."""
        ends = (foremost(machine, "housing"), foremost(machine, "shaft"))
        noses = [machine.nodes[node].name for node in ends if node is not None][:1]
        return {name: f"the hall and the {name}" for name in (*noses, *structure_parts(machine))}

    def prepare(self) -> None:
        """Find hall, part and the radial sensors."""
        self._hall = outside(self.machine)
        self._part = self.machine.node_index[self.driver]
        direction = np.radians(self.own("direction"))
        along = {"X": np.cos(direction), "Y": np.sin(direction)}
        signs = self.machine.signs
        self._moved = {
            name: signs[name] * along[axis]
            for name, axis in self.machine.probes.items()
            if axis in along
        }

    def target(self, inputs: Inputs, temperatures: FloatArray) -> FloatArray:
        """Return the temperature that the fixture follows, twice."""
        hall = inputs[self._hall] + 0.0 * temperatures[..., 0]
        share = self.own("nose_share")
        followed = (1.0 - share) * hall + share * temperatures[..., self._part]
        return np.stack([followed, followed], axis=-1)

    def reading(
        self, inputs: Inputs, states: FloatArray, time_s: FloatArray, readings: Readings
    ) -> None:
        """Move the radial readings."""
        moved = self.own("growth") * (states[..., 0] - states[..., 1])
        for name, share in self._moved.items():
            readings[name] = readings[name] + moved * share
