"""A column that bends if its temperature differs from the hall's."""

from __future__ import annotations

import numpy as np

from plant_model.anatomy import base_node, carrier_node, outside
from plant_model.effects.base import POSE, ROUND, Effect, Inputs
from plant_model.machine import Machine
from plant_model.parameters import FloatArray, Parameter


def add_tilt(
    out: FloatArray, angle: FloatArray, direction_deg: FloatArray, lever_mm: FloatArray
) -> None:
    """Add a tilt [urad] to the pose *out*, and the radial drift of a nose on a lever.

    Parameters
    ----------
    out : array, shape (sets, times, 6)
    angle : array, shape (sets, times)
    direction_deg : array, shape (sets or 1, 1)
        0 tilts towards X (yaw), 90 towards Y (pitch).
    lever_mm : array, shape (sets or 1, 1)
        From the centre of the tilt to the gauge line.
    """
    for tilt, shift, share in (
        ("yaw", "x", np.cos(np.radians(direction_deg))),
        ("pitch", "y", np.sin(np.radians(direction_deg))),
    ):
        out[..., POSE.index(tilt)] += angle * share
        out[..., POSE.index(shift)] += angle * share * lever_mm * 1e-3


DIFFERENCE, HALL, PARTS = "difference", "hall", "parts"


class ColumnBending(Effect):
    """Tilt k y with tau dy/dt = (T - T_hall) - y, y counted from the start of the run.

    T = s T_carrier + (1 - s) T_column, because the part that carries the spindle bends the column's
    front. With the driver ``hall``, walls of different thickness follow T_hall only; with ``parts``
    they follow T only: heat from the spindle reaches one side of the column.

    One wall of a column follows the hall sooner than the other. A difference of half of
    T_column - T_hall across 0.4 m bends 1.5 m of iron by 20 urad per kelvin; walls of 20 to 60 mm
    need 0.5 to 6 h (rho c t / h). These sizes are engineering judgement. Influence of the
    surroundings on machines: Mayr et al., CIRP Annals 61 (2012) 771-791,
    doi:10.1016/j.cirp.2012.05.008; its test: ISO 230-3. The column is the heaviest part that
    moves the nose and gives heat to the hall, the carrier the heaviest such part beside it.
    """

    title = "Column bending with the hall"
    explanation = (
        "The column follows the hall or its own parts unevenly and tilts the spindle, also at rest."
    )
    parameters = {
        "tilt": Parameter(8.0, "urad/K", 0.0, 40.0, "judgement: alpha L / w of columns"),
        "hours": Parameter(2.0, "h", 0.5, 6.0, "iron walls of 20 to 60 mm in still air"),
        "carrier_share": Parameter(0.5, "1", 0.0, 1.0, "judgement: either may bend the column"),
        "direction": Parameter(45.0, "deg", -180.0, 180.0, "0 tilts towards X, 90 towards Y"),
        "lever": Parameter(300.0, "mm", 0.0, 1500.0, "from the column's middle to the nose"),
    }
    law = ("hours",)
    tried = {
        "tilt": (16.0,),
        "hours": (0.8, 2.0, 5.0),
        "carrier_share": (0.0, 0.5, 1.0),
        "direction": ROUND,
        "lever": (0.0, 500.0),
    }
    states = ("difference", "at_start")
    lags = True

    @classmethod
    def drivers(cls, machine: Machine) -> dict[str, str]:
        """Return the difference, and each of its two sides."""
        column, carrier = base_node(machine), carrier_node(machine)
        names = " and ".join(dict.fromkeys(machine.nodes[n].name for n in (carrier, column)))
        return {
            DIFFERENCE: f"{names} against the hall",
            HALL: "the hall alone",
            PARTS: f"{names} alone",
        }

    @classmethod
    def unused(cls, driver: str) -> tuple[str, ...]:
        """Return the parameter that has no effect with the driver ``hall``."""
        return ("carrier_share",) if driver == HALL else ()

    def prepare(self) -> None:
        """Find the column, its carrier and the hall."""
        self._column, self._hall = base_node(self.machine), outside(self.machine)
        self._carrier = carrier_node(self.machine)
        self._driver = self.driver

    def target(self, inputs: Inputs, temperatures: FloatArray) -> FloatArray:
        """Return the bending temperature [K], twice: column and carrier minus hall, or one side."""
        hall = np.asarray(inputs[self._hall])[None, :]
        if self._driver == HALL:
            return np.stack([hall, hall], axis=-1)
        share = self.own("carrier_share")
        column, carrier = (temperatures[..., node] for node in (self._column, self._carrier))
        bends = share * carrier + (1.0 - share) * column
        if self._driver == DIFFERENCE:
            bends = bends - hall
        return np.stack([bends, bends], axis=-1)

    def displacement(
        self, inputs: Inputs, rise: FloatArray, states: FloatArray, out: FloatArray
    ) -> None:
        """Add the tilt."""
        angle = self.own("tilt") * (states[..., 0] - states[..., 1])
        add_tilt(out, angle, self.own("direction"), self.own("lever"))
