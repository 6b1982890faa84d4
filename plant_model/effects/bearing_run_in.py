"""Bearings that turn with more friction until their grease is spread."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from plant_model.anatomy import bearings
from plant_model.effects.base import Effect, Inputs
from plant_model.effects.bearing_friction import add_to_sides, bearing_heat
from plant_model.machine import Machine
from plant_model.parameters import FloatArray, Parameter

RUN, SERIES = "run", "series"


class BearingRunIn(Effect):
    """Friction times 1 + a exp(-t / tau); t are the hours turned, ``before`` and since the start.

    Grease churns until it is spread evenly, and torque and temperature are high until then (Lugt,
    Grease Lubrication in Rolling Bearings, Wiley 2013, doi:10.1002/9781118483961; Chatra, Osara and
    Lugt, Tribol. Int. (2023) 108375). NSK's run-in of new preloaded bearings takes up to 10 h in
    total (Tech Talk 06, Protect your bearing investment), so tau is seldom above 3 h; the range
    is wider. The size of the excess is engineering judgement. Hours at standstill do not count.
    Grease that flows back at standstill churns again in every run (driver ``run``). New or
    regreased bearings run in once (driver ``series``): a run then begins with the hours turned in
    the runs before it. The gap finder takes runs in the order of their names and does not know of
    hours between them. The excess is the same share of Palmgren's heat at every speed, at the given
    viscosity and preload.
    """

    title = "Bearings running in"
    explanation = (
        "Friction is higher in the first hours and falls with the hours that the bearings turned, "
        "in each run or in all runs together."
    )
    parameters = {
        "excess": Parameter(0.6, "1", 0.0, 2.0, "judgement; that grease churns: Lugt 2013"),
        "before": Parameter(0.0, "h", 0.0, 1e4, "hours turned before the first run"),
        "hours": Parameter(2.5, "h", 0.5, 10.0, "run-in of up to 10 h in all: NSK Tech Talk 06"),
    }
    law = ("hours",)
    temperature_dependent = True
    needs = ("bearing_friction",)
    given = ("before",)
    states = ("hours_turned",)
    known_ahead = True

    @classmethod
    def drivers(cls, machine: Machine) -> dict[str, str]:
        """Return which hours count: those of each run, or of all runs so far."""
        return {RUN: "the hours of each run", SERIES: "the hours of all runs so far"}

    @classmethod
    def unused(cls, driver: str) -> tuple[str, ...]:
        """Return the parameter that has no effect with the driver ``run``."""
        return ("before",) if driver == RUN else ()

    @classmethod
    def carried(
        cls, machine: Machine, driver: str, runs: Sequence[tuple[FloatArray, Inputs]]
    ) -> list[dict[str, float]]:
        """Return the hours turned before each run, and after the last."""
        if driver != SERIES:
            return []
        drivers = {item.refs["driven_by"][0] for item in bearings(machine)}
        turned = [
            float(np.sum(steps * np.any([inputs[name] != 0.0 for name in drivers], axis=0)))
            for steps, inputs in runs
        ]
        return [{"before": seconds / 3600.0} for seconds in np.cumsum([0.0, *turned]).tolist()]

    def prepare(self) -> None:
        """Find the bearings."""
        self._bearings = [(item, item.refs["driven_by"][0]) for item in bearings(self.machine)]

    def start_states(self, temperatures: FloatArray, inputs: Inputs) -> FloatArray:
        """Start with the hours turned before."""
        return np.broadcast_to(self.own("before"), (len(temperatures), 1))

    def rate(self, inputs: Inputs, temperatures: FloatArray, states: FloatArray) -> FloatArray:
        """Count the hours in which any bearing turns."""
        turning = np.zeros(states.shape)
        for _, driver in self._bearings:
            turning[..., 0] = np.maximum(turning[..., 0], inputs[driver] != 0.0)
        return turning / 3600.0

    def heat(
        self, inputs: Inputs, temperatures: FloatArray, states: FloatArray, out: FloatArray
    ) -> None:
        """Add the excess to every bearing's heat."""
        excess = self.own("excess") * np.exp(-states[..., 0] / self.own("hours"))
        for item, driver in self._bearings:
            add_to_sides(self, item, excess * bearing_heat(self, item, inputs[driver]), out)
