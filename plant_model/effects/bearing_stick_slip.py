"""A floating bearing that sticks in its seat."""

from __future__ import annotations

from typing import ClassVar

import numpy as np

from plant_model.effects.base import POSE, Effect, Inputs
from plant_model.parameters import FloatArray, Parameter


class BearingStickSlip(Effect):
    """The floating bearing stays in its seat until growth of shaft against housing exceeds h.

    u is the growth of the shaft beyond that of the housing from the rear end to the bearing that
    locates, s where the seat holds. While it holds, the shaft is strained and moves the nose by
    c (u - s). At |u - s| = h the seat lets go, s runs to u within half a minute, and it holds
    again: ds/dt = g (u - s) / 20 s with a bistable slip g, 10 s dg/dt = (1 + tanh(40 (|u - s| / h -
    1 + 0.9 g))) / 2 - g. Seats of floating bearings are meant to slide at some 100 N; fretting and
    tilt multiply that, and against 20 to 200 N/um of the locating bearing it makes 2 to 20 um
    (orders of magnitude: Weck and Brecher, Werkzeugmaschinen 2, 8th ed.). It does nothing where the
    structure has no shaft, housing and bearing that locates.
    """

    name: ClassVar[str] = "bearing_stick_slip"
    title: ClassVar[str] = "Floating bearing sticking and slipping"
    explanation: ClassVar[str] = (
        "The floating bearing holds until the shaft has grown enough, then lets the nose jump."
    )
    parameters: ClassVar[dict[str, Parameter]] = {
        "hold": Parameter(6.0, "um", 0.0, 20.0, "friction of the seat over bearing stiffness"),
        "share": Parameter(0.5, "1", 0.1, 1.0, "of the strain that reaches the nose, judgement"),
    }
    amplitude: ClassVar[str] = "hold"
    states: ClassVar[tuple[str, ...]] = ("seat", "slip", "at_start")
    state_scales: ClassVar[tuple[float, ...]] = (100.0, 100.0, 100.0)

    def prepare(self) -> None:
        """Collect the growth of shaft against housing per kelvin [um/K], (sets, nodes)."""
        machine = self.machine
        self._weights = np.zeros((self.values.sets, len(machine.nodes)))
        located = machine.of_kind("structure", "located")
        shafts, housings = (machine.of_kind("structure", kind) for kind in ("shaft", "housing"))
        self.acts = bool(located and shafts and housings)
        if not self.acts:
            return
        front = self.of(located[0], "at")
        rear = np.minimum.reduce([self.of(item, "start") for item in shafts])
        for item in (*shafts, *housings):
            low = np.maximum(self.of(item, "start"), rear)
            length = np.maximum(np.minimum(self.of(item, "end"), front) - low, 0.0)
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
        return np.concatenate([growth, np.zeros_like(growth), growth], axis=1)

    def rate(self, inputs: Inputs, temperatures: FloatArray, states: FloatArray) -> FloatArray:
        """Return how fast the seat slips, and how fast it lets go or catches."""
        strain = self._growth(temperatures) - states[..., 0]
        slip, hold = states[..., 1], self.own("hold")
        relative = np.abs(strain) / np.maximum(hold, 1e-9)
        wanted = 0.5 + 0.5 * np.tanh(40.0 * (np.minimum(relative, 5.0) - 1.0 + 0.9 * slip))
        rates = (slip * strain / 20.0, (wanted - slip) / 10.0, np.zeros_like(slip))
        return np.stack(np.broadcast_arrays(*rates), axis=-1)

    def displacement(
        self, inputs: Inputs, rise: FloatArray, states: FloatArray | None, out: FloatArray
    ) -> None:
        """Add what the strain moves the nose."""
        assert states is not None
        if self.acts:
            strain = self._growth(rise) + states[..., 2] - states[..., 0]
            held = np.where(self.own("hold") > 0.0, self.own("share"), 0.0)
            out[..., POSE.index("elongation")] += held * strain
