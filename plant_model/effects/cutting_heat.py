"""Heat from cutting that flows into tool and nose."""

from __future__ import annotations

import numpy as np

from plant_model.anatomy import input_in, nose
from plant_model.effects.base import Effect, Inputs
from plant_model.parameters import FloatArray, Parameter


class CuttingHeat(Effect):
    """A share s of the cutting power |M omega| warms tool and nose.

    The chip takes most of the power. The tool's share depends strongly on material and speed
    (review: Abukhshim, Mativenga and Sheikh, Int. J. Mach. Tools Manuf. 46 (2006) 782-800,
    doi:10.1016/j.ijmachtools.2005.07.024); coolant removes part of that. A share of 1 to 20 % of
    1 to 10 kW is engineering judgement. By default half of it reaches the foremost part of the
    shaft and half stays in the tool; without a tool in the structure all goes to the shaft. It does
    nothing on a machine without an input in Nm.
    """

    title = "Heat from cutting"
    explanation = "While cutting, a share of the cutting power warms tool and nose."
    parameters = {
        "share": Parameter(0.04, "1", 0.0, 0.2, "judgement: 1 to 20 % of the cutting power"),
        "tool_share": Parameter(0.5, "1", 0.0, 1.0, "judgement: as much stays as is passed on"),
    }
    physical = (0.0, 1.0)

    def prepare(self) -> None:
        """Find nose, tool and inputs."""
        tools = self.machine.of_kind("structure", "tool")
        self._tools = sorted({node for item in tools for node in self.nodes(item, "nodes")})
        self._nose = nose(self.machine)
        self._inputs = [input_in(self.machine, unit) for unit in ("Nm", "rpm")]

    def heat(
        self, inputs: Inputs, temperatures: FloatArray, states: FloatArray, out: FloatArray
    ) -> None:
        """Add the heat."""
        torque, speed = self._inputs
        if torque is None or speed is None or self._nose is None:
            return
        omega = inputs[speed.name] * (2.0 * np.pi / 60.0)
        power = self.own("share") * np.abs(inputs[torque.name] * omega)
        in_tool = self.own("tool_share") if self._tools else 0.0 * self.own("tool_share")
        out[..., self._nose] += (1.0 - in_tool) * power
        for node in self._tools:
            out[..., node] += in_tool * power / len(self._tools)
