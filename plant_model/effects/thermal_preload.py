"""Preload that grows as the inner ring gets warmer than the outer."""

from __future__ import annotations

import numpy as np

from plant_model.anatomy import around_bearing, bearings
from plant_model.effects.base import Effect, Inputs
from plant_model.effects.bearing_friction import add_to_sides, friction_heat
from plant_model.machine import Item, Machine
from plant_model.parameters import FloatArray, Parameter

RINGS, SEAT = "inner_outer", "shaft_housing"
Sides = tuple[tuple[int, ...], tuple[int, ...]]


def _rings(machine: Machine, bearing: Item) -> Sides:
    """Return the bearing's own inner and outer side."""
    inner, outer = (machine.node_index[bearing.refs[side][0]] for side in ("inner", "outer"))
    return (inner,), (outer,)


def _mean(temperatures: FloatArray, nodes: tuple[int, ...]) -> FloatArray:
    """Return the mean temperature of some nodes, shape (sets, times)."""
    return np.asarray(sum(temperatures[..., node] for node in nodes) / len(nodes))


class ThermalPreload(Effect):
    """Palmgren's load torque times 1 + k max(D, 0), with D = T_inner - T_outer of the bearing.

    With the driver ``shaft_housing``, D is the shaft's temperature minus that of the housing, each
    the mean of the parts that the bearing touches there: clamped rings follow shaft and bore, and a
    cooled housing around a warm shaft tightens them long after the rings have equal temperatures.

    A warm inner ring takes up clearance. A 70 mm ring grows by 0.4 um per kelvin in radius,
    compared with an elastic approach of 1 to 5 um under preload, and load rises with the power 3/2
    of approach: k is 0.1 to 0.6 per kelvin for stiffly clamped bearings, small for spring preload
    (Hertz stiffness: Harris and Kotzalas, Essential Concepts of Bearing Technology, 5th ed., ch. 6
    and 8; thermally induced preload in spindles: Stein and Tu, J. Dyn. Syst. Meas. Control 116
    (1994) 372-386). The approach under preload is engineering judgement, and the range is wider.
    At ten times its load torque a bearing is assumed to be about to seize: the factor is limited
    to that. The axial shift from the clearance taken up, cot(contact angle) times it, is left out:
    it cancels between the two bearings of a pair, and for a bearing on springs its size is not
    known in general.
    """

    title = "Preload rising with the temperature difference in the bearing"
    explanation = (
        "After a speed-up the inner ring, or the shaft, warms first; the bearing tightens and "
        "heats more."
    )
    parameters = {
        "gain": Parameter(0.2, "1/K", 0.0, 2.0, "judgement: ring growth against approach")
    }
    temperature_dependent = True
    needs = ("bearing_friction",)
    most = 10.0

    @classmethod
    def drivers(cls, machine: Machine) -> dict[str, str]:
        """Return the two differences, or only the first if both are the same."""
        words = {RINGS: "inner ring against outer ring"}
        others = any(
            around_bearing(machine, item) != _rings(machine, item) for item in bearings(machine)
        )
        return words | ({SEAT: "shaft against housing"} if others else {})

    def prepare(self) -> None:
        """Find the bearings, the nodes that tighten each, and its load torque [N mm]."""
        between = around_bearing if self.driver == SEAT else _rings
        self._bearings = [
            (
                item,
                between(self.machine, item),
                self.scale_of("bearing_friction")
                * self.of(item, "count")
                * self.of(item, "f1")
                * self.of(item, "preload")
                * self.of(item, "mean_diameter"),
            )
            for item in bearings(self.machine)
        ]

    def heat(
        self, inputs: Inputs, temperatures: FloatArray, states: FloatArray, out: FloatArray
    ) -> None:
        """Add the heat of the torque in excess of that at the given preload."""
        for item, sides, torque in self._bearings:
            inside, outside = (_mean(temperatures, nodes) for nodes in sides)
            warmer = np.maximum(inside - outside, 0.0)
            factor = np.minimum(self.own("gain") * warmer, self.most - 1.0)
            speed = inputs[item.refs["driven_by"][0]]
            add_to_sides(self, item, friction_heat(speed, torque * factor), out)
