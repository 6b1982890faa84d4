"""Preload that grows as the inner ring gets warmer than the outer."""

from __future__ import annotations

from typing import ClassVar

import numpy as np

from plant_model.anatomy import bearings
from plant_model.effects.base import Effect, Inputs
from plant_model.effects.bearing_friction import add_to_sides, friction_heat
from plant_model.parameters import FloatArray, Parameter


class ThermalPreload(Effect):
    """Palmgren's load torque times 1 + k max(T_inner - T_outer, 0).

    A warm inner ring takes up clearance. A 70 mm ring grows by 0.4 um a kelvin in radius, against
    an elastic approach of 1 to 5 um under preload, and load rises with the power 3/2 of approach:
    k of 0.1 to 0.6 per kelvin for bearings clamped stiffly, little for spring preload (Hertz
    stiffness: Harris and Kotzalas, Essential Concepts of Bearing Technology, 5th ed., ch. 6 and 8;
    thermally induced preload in spindles: Stein and Tu, J. Dyn. Syst. Meas. Control 116 (1994)
    372-386). The approach under preload is engineering judgement, and the range reaches wider. At
    ten times its load torque a bearing is taken to be about to seize: the factor goes no further.
    """

    name: ClassVar[str] = "thermal_preload"
    title: ClassVar[str] = "Preload rising with the temperature difference in the bearing"
    explanation: ClassVar[str] = (
        "After a speed-up the inner ring warms first, the bearing tightens and heats more."
    )
    parameters: ClassVar[dict[str, Parameter]] = {
        "gain": Parameter(0.2, "1/K", 0.0, 2.0, "judgement: ring growth against approach")
    }
    amplitude: ClassVar[str] = "gain"
    temperature_dependent: ClassVar[bool] = True
    needs: ClassVar[tuple[str, ...]] = ("bearing_friction",)
    most: ClassVar[float] = 10.0

    def prepare(self) -> None:
        """Find the bearings and the load torque of each [N mm]."""
        self._bearings = [
            (
                item,
                self.nodes(item, "inner")[0],
                self.nodes(item, "outer")[0],
                self.scale_of("bearing_friction")
                * self.of(item, "count")
                * self.of(item, "f1")
                * self.of(item, "preload")
                * self.of(item, "mean_diameter"),
            )
            for item in bearings(self.machine)
        ]

    def heat(
        self,
        inputs: Inputs,
        temperatures: FloatArray | None,
        states: FloatArray | None,
        out: FloatArray,
    ) -> None:
        """Add the heat of the torque beyond that at the preload given."""
        assert temperatures is not None
        for item, inner, outer, torque in self._bearings:
            warmer = np.maximum(temperatures[..., inner] - temperatures[..., outer], 0.0)
            factor = np.minimum(self.own("gain") * warmer, self.most - 1.0)
            speed = inputs[item.refs["driven_by"][0]]
            add_to_sides(self, item, friction_heat(speed, torque * factor), out)
