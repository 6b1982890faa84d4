"""A bearing that is warmer on one side of its race."""

from __future__ import annotations

from typing import ClassVar

import numpy as np

from plant_model.anatomy import bearings
from plant_model.effects.base import ROUND, Effect, Inputs
from plant_model.effects.bearing_friction import bearing_heat
from plant_model.effects.column_bending import add_tilt
from plant_model.parameters import FloatArray, Parameter


class UnevenBearingHeating(Effect):
    """Tilt alpha (L / w) D, with tau dD/dt = D_ref P / P_ref - D across the race.

    P is the bearings' heat at the speed in force and P_ref that at half of the highest speed. Load
    zones, an oil inlet or a rib make one side warmer; up to 5 K around the circumference is
    engineering judgement, as are lag, zone and lever. alpha = 11.5e-6/K for steel; L / w is the
    length over the width of the zone that bends. No tilt of its own at rest.
    """

    name: ClassVar[str] = "uneven_bearing_heating"
    title: ClassVar[str] = "Uneven heat around the bearing"
    explanation: ClassVar[str] = (
        "One side of the race is warmer, so the nose tilts as the bearings heat."
    )
    parameters: ClassVar[dict[str, Parameter]] = {
        "difference": Parameter(1.5, "K", 0.0, 5.0, "judgement: outer rings of spindles"),
        "minutes": Parameter(15.0, "min", 3.0, 60.0, "capacity over conductance of a seat"),
        "direction": Parameter(0.0, "deg", -180.0, 180.0, "0 tilts towards X, 90 towards Y"),
        "slenderness": Parameter(0.8, "1", 0.3, 2.0, "length over width of the warm zone"),
        "lever": Parameter(100.0, "mm", 0.0, 500.0, "from the bearing to the gauge line"),
    }
    amplitude: ClassVar[str] = "difference"
    law: ClassVar[tuple[str, ...]] = ("minutes",)
    tried: ClassVar[dict[str, tuple[float, ...]]] = {
        "difference": (2.0,),
        "minutes": (5.0, 15.0, 45.0),
        "direction": ROUND,
        "lever": (0.0, 100.0, 400.0),
    }
    needs: ClassVar[tuple[str, ...]] = ("bearing_friction",)
    states: ClassVar[tuple[str, ...]] = ("relative",)
    lags: ClassVar[bool] = True
    expansion: ClassVar[float] = 11.5  # 1e-6/K

    def prepare(self) -> None:
        """Find the bearings and their heat at half of the highest speed [W]."""
        highest = {entry.name: entry.most for entry in self.machine.inputs}
        self._bearings = [(item, item.refs["driven_by"][0]) for item in bearings(self.machine)]
        self._reference = sum(
            (
                bearing_heat(self, item, np.array([highest[name] / 2.0]))
                for item, name in self._bearings
            ),
            np.zeros((1, 1)),
        )

    def target(self, inputs: Inputs, temperatures: FloatArray) -> FloatArray:
        """Return the bearings' heat against that at the reference speed."""
        power = sum(
            (bearing_heat(self, item, inputs[name]) for item, name in self._bearings),
            np.zeros((1, 1)),
        )
        relative = power / np.maximum(self._reference, 1e-9)
        shape = (*np.broadcast_shapes(relative.shape, (1, temperatures.shape[1])), 1)
        return np.broadcast_to(relative[..., None], shape)

    def time_constants(self) -> FloatArray:
        """Return the lag of the ring."""
        return 60.0 * self.own("minutes")

    def start_states(self, temperatures: FloatArray, inputs: Inputs) -> FloatArray:
        """Start with an even ring."""
        return np.zeros((len(temperatures), 1))

    def displacement(
        self, inputs: Inputs, rise: FloatArray, states: FloatArray | None, out: FloatArray
    ) -> None:
        """Add the tilt."""
        assert states is not None
        per_kelvin = self.expansion * self.own("slenderness")
        angle = per_kelvin * self.own("difference") * states[..., 0]
        add_tilt(out, angle, self.own("direction"), self.own("lever"))
