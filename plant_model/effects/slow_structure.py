"""A bed that follows the hall over many hours."""

from __future__ import annotations

import numpy as np

from plant_model.anatomy import outside, structure_parts
from plant_model.effects.base import POSE, ROUND, Effect, Inputs
from plant_model.machine import Machine
from plant_model.parameters import FloatArray, Parameter

HALL = "hall"


class SlowStructure(Effect):
    """Growth k y with tau dy/dt = (T - T at the start) - y; T is the hall's temperature.

    With a part as driver, T = s T_part + (1 - s) T_hall: a bed follows the part that stands on it,
    the hall, or both.

    Bed and column between tool and work are metres of iron (11 um/(m K)) with a lag of hours: from
    3 h for a column in moving air to 20 h for a bed on its foundation, by engineering judgement
    (influence of the hall on machines: Mayr et al., CIRP Annals 61 (2012) 771-791,
    doi:10.1016/j.cirp.2012.05.008; its test: environmental temperature variation error, ISO 230-3).
    ``direction`` turns the growth from the elongation (0) to the radial drift (90), ``azimuth``
    turns that drift from X (0) to Y (90).
    """

    title = "Bed following the hall slowly"
    explanation = (
        "Bed and column grow hours after the hall, or after a part of the machine, so drift never "
        "settles."
    )
    parameters = {
        "growth": Parameter(8.0, "um/K", 0.0, 30.0, "judgement: 0.1 to 3 m of iron"),
        "hours": Parameter(8.0, "h", 3.0, 20.0, "judgement: column in air to bed on foundation"),
        "direction": Parameter(0.0, "deg", -180.0, 180.0, "0 is elongation, 90 radial"),
        "part_share": Parameter(0.5, "1", 0.0, 1.0, "judgement: of the part, the rest of the hall"),
        "azimuth": Parameter(90.0, "deg", -90.0, 90.0, "0 is X, 90 is Y"),
    }
    law = ("hours",)
    tried = {
        "growth": (8.0,),
        "hours": (3.5, 7.0, 14.0),
        "direction": ROUND,
        "part_share": (0.5, 1.0),
        "azimuth": (-45.0, 0.0, 45.0, 90.0),
    }
    states = ("hall", "at_start")
    lags = True

    @classmethod
    def drivers(cls, machine: Machine) -> dict[str, str]:
        """Return the hall and the parts that the work may stand on."""
        return {HALL: "the hall"} | {
            name: f"the {name} and the hall" for name in structure_parts(machine)
        }

    @classmethod
    def unused(cls, driver: str) -> tuple[str, ...]:
        """Return the parameter that has no effect with the driver ``hall``."""
        return ("part_share",) if driver == HALL else ()

    def prepare(self) -> None:
        """Find the hall, the part and the directions of the growth."""
        self._hall = outside(self.machine)
        # By name, because calibrating capacities may change which parts are the heaviest.
        self._part = None if self.driver == HALL else self.machine.node_index[self.driver]
        direction, azimuth = (np.radians(self.own(name)) for name in ("direction", "azimuth"))
        self._shares = {
            "elongation": np.cos(direction),
            "x": np.sin(direction) * np.cos(azimuth),
            "y": np.sin(direction) * np.sin(azimuth),
        }

    def target(self, inputs: Inputs, temperatures: FloatArray) -> FloatArray:
        """Return the temperature that the bed follows, twice."""
        followed = np.asarray(inputs[self._hall])[None, :]
        if self._part is not None:
            share = self.own("part_share")
            followed = share * temperatures[..., self._part] + (1.0 - share) * followed
        return np.stack([followed, followed], axis=-1)

    def displacement(
        self, inputs: Inputs, rise: FloatArray, states: FloatArray, out: FloatArray
    ) -> None:
        """Add the growth."""
        growth = self.own("growth") * (states[..., 0] - states[..., 1])
        for axis, share in self._shares.items():
            out[..., POSE.index(axis)] += growth * share
