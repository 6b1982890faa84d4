"""A floating bearing that sticks in its seat."""

from __future__ import annotations

from functools import reduce

import numpy as np

from plant_model.effect_names import leaps_of
from plant_model.effects.base import POSE, Effect, Inputs
from plant_model.effects.thermal_expansion import located, stretch
from plant_model.parameters import FloatArray, Parameter


class BearingStickSlip(Effect):
    """The floating bearing sticks in its seat until the shaft outgrows the housing by h.

    u is the growth of the shaft minus that of the housing, from the rear end to the locating
    bearing, and s the value of u at which the seat sticks. While it sticks, the shaft is strained
    and moves the nose by c (u - s). At |u - s| = h the seat slips: s jumps until a tenth of the
    strain remains (sliding friction is lower than static friction, so it overshoots), and it
    sticks again. Seats of floating bearings are meant to slide at some 100 N; fretting and tilt
    multiply that, and with 20 to 200 N/um of the locating bearing this gives 2 to 20 um (all of it
    engineering judgement). The range is twice as wide, because a model with few parts may grow
    more than the machine. It does nothing if the structure lacks a shaft or a housing.

    The instants of slips depend on the last tenths of a micrometre. In a measured run the seat
    also slips when the measured nose leaps, if it leaps the right way and at least half of the
    strain *hold* is there.
    """

    title = "Floating bearing sticking and slipping"
    explanation = (
        "The floating bearing holds until the shaft has grown enough, then lets the nose jump."
    )
    parameters = {
        "hold": Parameter(6.0, "um", 0.0, 40.0, "friction of the seat over bearing stiffness"),
        "share": Parameter(0.5, "1", 0.1, 1.0, "of the strain that reaches the nose, judgement"),
    }
    states = ("seat", "at_start")
    settles = True
    given = ("hold",)
    tried = {
        "hold": tuple(1.5 * 1.1**i for i in range(35)),
        "share": (0.5,),
    }
    proportional = "share"
    left = 0.1  # share of the strain after a slip
    least = 0.5  # share of *hold* at which a measured leap is a slip

    def prepare(self) -> None:
        """Collect the growth of shaft minus housing per kelvin [um/K], (sets, nodes)."""
        machine = self.machine
        self._weights = np.zeros((self.values.sets, len(machine.nodes)))
        shafts, housings = (machine.of_kind("structure", kind) for kind in ("shaft", "housing"))
        self.acts = bool(shafts and housings)
        if not self.acts:
            return
        front, _ = located(self)
        rear = reduce(np.minimum, [self.of(item, "start") for item in shafts])
        for item in (*shafts, *housings):
            length, _ = stretch(self, item, rear, front)
            growth = self.of(item, "expansion") * length * 1e-3
            sign = 1.0 if item.kind == "shaft" else -1.0
            nodes = self.nodes(item, "nodes")
            for node in nodes:
                self._weights[:, node] += sign * growth[:, 0] / len(nodes)

    def _growth(self, temperatures: FloatArray) -> FloatArray:
        """Return the growth [um], (sets, times), for temperatures or their rise."""
        return np.asarray((temperatures @ self._weights[..., None])[..., 0])

    def start_states(self, temperatures: FloatArray, inputs: Inputs) -> FloatArray:
        """Start without strain."""
        growth = self._growth(temperatures[:, None, :])
        return np.concatenate([growth, growth], axis=1)

    def settled(self, inputs: Inputs, temperatures: FloatArray, states: FloatArray) -> FloatArray:
        """Let the seat slip if the strain has reached *hold*, or if the measured nose leaps."""
        growth = self._growth(temperatures[:, None, :])[:, 0]
        strain, hold = growth - states[:, 0], self.own("hold")[:, 0]
        size = np.abs(strain)
        seen = inputs.get(leaps_of(self.key), np.zeros(1)) * np.sign(strain) < 0.0
        lets_go = (size >= hold) | (seen & (size >= self.least * hold))
        caught = growth - self.left * np.minimum(hold, size) * np.sign(strain)
        return np.stack([np.where(lets_go, caught, states[:, 0]), states[:, 1]], axis=1)

    def displacement(
        self, inputs: Inputs, rise: FloatArray, states: FloatArray, out: FloatArray
    ) -> None:
        """Add the motion of the nose by the strain."""
        if self.acts:
            strain = self._growth(rise) + states[..., 1] - states[..., 0]
            held = np.where(self.own("hold") > 0.0, self.own("share"), 0.0)
            out[..., POSE.index("elongation")] += held * strain
