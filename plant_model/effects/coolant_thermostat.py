"""A chiller that switches its cooling on and off."""

from __future__ import annotations

from typing import ClassVar

import numpy as np

from plant_model.anatomy import incidence
from plant_model.effects.base import Effect, Inputs
from plant_model.parameters import FloatArray, Parameter


class CoolantThermostat(Effect):
    """What reaches the jackets swings by +-b around the inlet's reading, between dead-band limits.

    y = dT / b climbs while the compressor rests and falls while it runs, dy/dt = -(4 / p) r, and
    the relay holds until a limit is passed: tau dr/dt = tanh(s (c y + r)) - r, bistable for s > 1.
    tau is a sixtieth of the period p; c brings the turning points to y = +-1. Where in its cycle a
    run begins is a parameter. Two-point chillers keep +-0.5 to 2 K, and switch no more than some
    ten times an hour to spare the compressor. It acts on every flow that a boundary feeds.
    """

    name: ClassVar[str] = "coolant_thermostat"
    title: ClassVar[str] = "Chiller switching on and off"
    explanation: ClassVar[str] = (
        "The chiller's dead band makes the coolant's temperature swing, whatever the spindle does."
    )
    parameters: ClassVar[dict[str, Parameter]] = {
        "band": Parameter(0.6, "K", 0.0, 1.5, "two-point chillers keep +-0.5 to 2 K"),
        "period": Parameter(15.0, "min", 5.0, 40.0, "up to some ten switchings an hour"),
        "phase": Parameter(0.0, "1", 0.0, 1.0, "any; 0 is the coldest instant"),
    }
    amplitude: ClassVar[str] = "band"
    temperature_dependent: ClassVar[bool] = True
    states: ClassVar[tuple[str, ...]] = ("swing", "relay")
    state_scales: ClassVar[tuple[float, ...]] = (20.0, 100.0)
    steepness: ClassVar[float] = 20.0
    coupling: ClassVar[float] = 0.97

    def prepare(self) -> None:
        """Find the flows that a boundary feeds."""
        boundaries = self.machine.boundary_index
        flows = [
            item
            for item in self.machine.of_kind("links", "coolant_flow")
            if item.refs["between"][1] in boundaries
        ]
        nodes = [self.machine.node_index[item.refs["between"][0]] for item in flows]
        scale = self.scale_of("coolant_jacket") / 60.0
        carried = [scale * self.of(item, "flow") * self.of(item, "heat_capacity") for item in flows]
        self._carried = self.table(carried) @ incidence(nodes, len(self.machine.nodes))
        self._period_s = 60.0 * self.own("period")

    def start_states(self, temperatures: FloatArray, inputs: Inputs) -> FloatArray:
        """Start at the phase given: rising from -1 in its first half, falling in the second."""
        phase = self.own("phase") % 1.0
        swing = 1.0 - 4.0 * np.abs(phase - 0.5)
        return np.concatenate([swing, np.where(phase < 0.5, -1.0, 1.0)], axis=1)

    def rate(self, inputs: Inputs, temperatures: FloatArray, states: FloatArray) -> FloatArray:
        """Return how fast the swing and the relay move."""
        swing, relay = states[..., 0], states[..., 1]
        wanted = np.tanh(self.steepness * (self.coupling * swing + relay))
        fast = 60.0 / self._period_s
        return np.stack([-4.0 / self._period_s * relay, fast * (wanted - relay)], axis=-1)

    def heat(
        self,
        inputs: Inputs,
        temperatures: FloatArray | None,
        states: FloatArray | None,
        out: FloatArray,
    ) -> None:
        """Add what the warmer or colder coolant brings."""
        assert states is not None
        out += (self.own("band") * states[..., 0])[..., None] * self._carried
