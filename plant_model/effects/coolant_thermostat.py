"""A chiller that switches its cooling on and off."""

from __future__ import annotations

import numpy as np

from plant_model.anatomy import measured_parts
from plant_model.effect_names import switched_by
from plant_model.effects.base import Effect, Inputs
from plant_model.effects.coolant_jacket import carried_from_inlets, flows_of
from plant_model.machine import Machine
from plant_model.parameters import FloatArray, Parameter

CLOCK = "own_clock"


class CoolantThermostat(Effect):
    """Coolant at the jackets swings by +-b around the inlet's reading, between dead-band limits.

    With its own clock, dT = b y rises while the compressor rests and falls while it runs, at the
    same constant rate: y goes from -1 to 1 and back in a period p. The place in the cycle at which
    a run begins is a parameter. It acts on every flow from a boundary.

    With a part that has a thermometer as driver, cooling starts when the part is warmer than T_on
    and stops when it is colder than T_on - d; a run that begins below T_on starts without cooling.
    While the cooling rests, the coolant that enters a jacket is warmer than its feed by 2 b, but
    never warmer than the jacket: coolant at a standstill takes the jacket's temperature, so a large
    b describes a flow that stops. The walls' films do not change; with a pump that stops they would
    fall as well, which this effect does not explain. It switches at the end of a step.

    Two-point chillers keep +-0.5 to 2 K, and switch at most some ten times an hour to spare the
    compressor (engineering judgement; see the chiller's data sheet). The studies switch their
    cooler by a threshold on the spindle.
    """

    title = "Chiller switching on and off"
    explanation = (
        "The chiller's dead band makes the coolant's temperature swing, or a part that gets warm "
        "switches the cooling."
    )
    parameters = {
        "band": Parameter(0.6, "K", 0.0, 1.5, "judgement: two-point chillers keep +-0.5 to 2 K"),
        "period": Parameter(15.0, "min", 5.0, 40.0, "judgement: up to some ten switchings an hour"),
        "phase": Parameter(0.0, "1", 0.0, 1.0, "any; 0 is the coldest instant"),
        "on_above": Parameter(30.0, "degC", -60.0, 200.0, "any: the setting of the cooler"),
        "dead_band": Parameter(2.0, "K", 0.1, 50.0, "any: the setting of the cooler"),
    }
    temperature_dependent = True
    swings = ("period", "phase")
    switched = ("on_above", "dead_band")
    given = switched
    states = ("cycle",)
    state_scales = (100.0,)

    @classmethod
    def drivers(cls, machine: Machine) -> dict[str, str]:
        """Return its own clock, and the parts with a thermometer that may switch a cooler."""
        cooled = machine.of_kind("links", "coolant_flow")
        parts = measured_parts(machine) if cooled else []
        return {CLOCK: "its own clock"} | {name: f"the {name}" for name in parts}

    @classmethod
    def unused(cls, driver: str) -> tuple[str, ...]:
        """Return the parameters that have no effect with the clock or with a part."""
        return cls.switched if driver == CLOCK else cls.swings

    def prepare(self) -> None:
        """Compute the heat capacity rates of the flows into every node [W/K]."""
        self.settles = self.driver != CLOCK
        self.known_ahead = not self.settles
        self._period_s = 60.0 * self.own("period")
        self._carried = carried_from_inlets(self, np.ones((1, 1)))
        self._part = self.machine.node_index.get(self.driver, 0)
        self._flows = flows_of(self.machine, self.values)

    def start_states(self, temperatures: FloatArray, inputs: Inputs) -> FloatArray:
        """Start at the given phase; with a part, running if it is too warm, else resting."""
        if not self.settles:
            return np.broadcast_to(self.own("phase"), (len(temperatures), 1))
        return self.settled(inputs, temperatures, np.zeros((len(temperatures), 1)))

    def rate(self, inputs: Inputs, temperatures: FloatArray, states: FloatArray) -> FloatArray:
        """Return the rate of the cycle."""
        return np.broadcast_to(1.0 / self._period_s[..., None], states.shape)

    def settled(self, inputs: Inputs, temperatures: FloatArray, states: FloatArray) -> FloatArray:
        """Switch if the part has left the dead band; 1 runs, 0 rests."""
        if switched_by(self.key) in inputs:
            return np.broadcast_to(inputs[switched_by(self.key)], states.shape)
        part = temperatures[:, self._part, None]
        on_above, band = self.own("on_above"), self.own("dead_band")
        rests = np.where(part < on_above - band, 0.0, states)
        return np.asarray(np.where(part > on_above, 1.0, rests))

    def heat(
        self, inputs: Inputs, temperatures: FloatArray, states: FloatArray, out: FloatArray
    ) -> None:
        """Add the heat of the warmer or colder coolant."""
        if not self.settles:
            swing = 1.0 - 4.0 * np.abs(states[..., 0] % 1.0 - 0.5)
            out += (self.own("band") * swing)[..., None] * self._carried
            return
        rests, most = 1.0 - states[..., 0], 2.0 * self.own("band")
        for flow in self._flows:
            colder = np.maximum(-flow.warmer(self.machine, inputs, temperatures), 0.0)
            out[..., flow.node] += flow.conductance * rests * np.minimum(colder, most)
