"""Holder and tool warmed by the nose."""

from __future__ import annotations

import numpy as np

from plant_model.anatomy import nose, outside
from plant_model.effects.base import POSE, Effect, Inputs
from plant_model.parameters import FloatArray, Parameter


class ToolHeating(Effect):
    """Heat G (T_nose - T_holder) into the holder, on into the tool, and from both to the hall.

    Own states are the temperatures of holder and tool. Both come out of the magazine at the hall's
    temperature and then follow the hall, like the rest of the machine: a holder of 80 mm grows by
    0.9 um for each kelvin that the hall rises. The holder's growth since the start, over its
    length, adds to the elongation, the tool's to the growth per length. If the structure has a tool
    of its own, it already follows the hall, and only the excess over the hall is added. G: an HSK
    or SK taper has 2 to 20 W/K across its joint, and some 50 mm of shank in series, 1 to 8 W/K in
    total (k A / L, steel 48 W/(m K)). Half of the capacity is the holder's. Joint, masses, lengths
    and films are engineering judgement. No taper conducts less than 0.5 W/K: below that the growth
    fades out, so that nothing grows without a holder.
    """

    title = "Holder and tool warming"
    explanation = (
        "The warm nose heats holder and tool, which go on growing after it and with the hall."
    )
    parameters = {
        "conductance": Parameter(2.0, "W/K", 0.0, 8.0, "judgement: joint, and k A / L of shank"),
        "capacity": Parameter(900.0, "J/K", 200.0, 3000.0, "0.4 to 6 kg of steel"),
        "holder_length": Parameter(80.0, "mm", 20.0, 250.0, "judgement: usual holders"),
        "loss": Parameter(0.8, "W/K", 0.1, 3.0, "20 to 60 W/(m2 K) on 0.005 to 0.05 m2, turning"),
    }
    temperature_dependent = True
    states = ("holder", "tool", "at_start")
    expansion = 11.5  # 1e-6/K, steel
    shank = 0.5  # W/K, from the holder into a tool of 20 to 30 mm
    least_joint = 0.5  # W/K

    def prepare(self) -> None:
        """Find the nose and the hall."""
        self._nose, self._hall = nose(self.machine), outside(self.machine)
        self._in_structure = bool(self.machine.of_kind("structure", "tool"))

    def start_states(self, temperatures: FloatArray, inputs: Inputs) -> FloatArray:
        """Start at the hall's temperature."""
        hall = np.broadcast_to(inputs[self._hall], (len(temperatures), 1))
        return np.concatenate([hall] * len(self.states), axis=1)

    def state_decay(self) -> FloatArray:
        """Return the rates at which holder and tool lose their own heat [1/s]."""
        lost = self.shank + 0.5 * self.own("loss")
        taken = self.own("conductance") if self._nose is not None else 0.0
        each = np.broadcast_arrays(lost + taken, lost, np.zeros((1, 1)))
        return np.asarray(np.concatenate(each, axis=-1) / (0.5 * self.own("capacity")))

    def _taken(self, inputs: Inputs, temperatures: FloatArray, states: FloatArray) -> FloatArray:
        """Return the heat that the holder takes from the nose [W]."""
        if self._nose is None:
            return np.zeros(states.shape[:-1])
        warmer = temperatures[..., self._nose] - states[..., 0]
        return np.asarray(self.own("conductance") * warmer)

    def rate(self, inputs: Inputs, temperatures: FloatArray, states: FloatArray) -> FloatArray:
        """Return the rates of warming of holder and tool [K/s]."""
        holder, tool = states[..., 0], states[..., 1]
        on = self.shank * (holder - tool)
        loss, hall = 0.5 * self.own("loss"), inputs[self._hall]
        half = 0.5 * self.own("capacity")
        taken = self._taken(inputs, temperatures, states)
        warms = [taken - on - loss * (holder - hall), on - loss * (tool - hall), 0.0 * tool]
        return np.stack([power / half for power in warms], axis=-1)

    def heat(
        self, inputs: Inputs, temperatures: FloatArray, states: FloatArray, out: FloatArray
    ) -> None:
        """Subtract the holder's heat from the nose."""
        if self._nose is not None:
            out[..., self._nose] -= self._taken(inputs, temperatures, states)

    def displacement(
        self, inputs: Inputs, rise: FloatArray, states: FloatArray, out: FloatArray
    ) -> None:
        """Add the growth of holder and tool."""
        if self._nose is None:
            return
        joined = np.minimum(self.own("conductance") / self.least_joint, 1.0)
        per_mm = joined * self.expansion * 1e-3
        holder, tool, at_start = (states[..., i] for i in range(3))
        already = inputs[self._hall] if self._in_structure else at_start
        out[..., POSE.index("elongation")] += (
            per_mm * self.own("holder_length") * (holder - at_start)
        )
        out[..., POSE.index("tool_strain")] += per_mm * (tool - already)
