"""Pose and readings of one machine at one instant: `sensors.readings` and `structure` made fast.

A co-simulation asks for one instant at a time, and arrays of one element cost more than the
arithmetic on them. So here a pose is six floats and the readings are one flat array. Only effects
with a hook for the pose or the readings cost anything.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np

from plant_model.effects import Effect
from plant_model.effects.base import POSE
from plant_model.machine import Machine
from plant_model.parameters import FloatArray
from plant_model.sensors import displacement_names
from plant_model.structure import RAD_PER_URAD, UM_PER_MM

Drift = tuple[float, float, float]
NOWHERE = slice(0, 0)


class Instant:
    """The pose and the exact readings of a machine with one set of parameters.

    Parameters
    ----------
    machine : Machine
    effects : sequence of Effect
        Those in force.
    slices : dict of str to slice
        Positions of each effect's own states.

    Attributes
    ----------
    names : list of str
        The sensors, in the order of the readings: thermometers, then the displacement rig.
    """

    def __init__(
        self, machine: Machine, effects: Sequence[Effect], slices: Mapping[str, slice]
    ) -> None:
        index = machine.node_index
        thermometers = machine.sensors
        self.names = [*(sensor.name for sensor in thermometers), *displacement_names(machine)]
        on_nodes = [(i, index[s.of]) for i, s in enumerate(thermometers) if s.of in index]
        self._places = np.array([place for place, _ in on_nodes], dtype=np.intp)
        self._nodes = np.array([node for _, node in on_nodes], dtype=np.intp)
        self._of_inputs = [(i, s.of) for i, s in enumerate(thermometers) if s.of not in index]
        self._count = len(thermometers)
        self._machine = machine
        self._inputs = {entry.name: np.zeros(1) for entry in machine.inputs}
        self._moving = [
            (effect, slices.get(effect.key, NOWHERE))
            for effect in effects
            if _has(effect, "displacement")
        ]
        # A lagging sensor replaces its reading, so it comes before the errors added to it.
        self._showing = sorted(
            (
                (effect, slices.get(effect.key, NOWHERE))
                for effect in effects
                if _has(effect, "reading")
            ),
            key=lambda entry: not entry[0].states,
        )

    def at(
        self,
        state: FloatArray,
        start: FloatArray,
        inputs: Mapping[str, float],
        time_s: float,
    ) -> tuple[list[float], FloatArray]:
        """Return the pose and the readings without noise.

        Parameters
        ----------
        state : array, shape (nodes + own states,)
            Temperatures [degC] and the effects' own states.
        start : array, shape (nodes,)
            Temperatures at the start [degC].
        inputs : mapping of str to float
            The machine's inputs.
        time_s : float
            Since the start [s].

        Returns
        -------
        pose : list of float
            In the order of ``effects.base.POSE``.
        readings : array, shape (sensors,)
            In the order of *names* [degC or um].
        """
        nodes = len(start)
        arrays = self._inputs
        for name, array in arrays.items():
            array[0] = inputs[name]
        states = state[nodes:]
        rise = (state[:nodes] - start)[None, None]
        out = np.zeros((1, 1, len(POSE)))
        for effect, part in self._moving:
            own = states[None, None, part]
            effect.displacement(arrays, rise, own, out)
        pose: list[float] = out[0, 0].tolist()
        shown = np.empty(len(self.names))
        shown[self._places] = state[self._nodes]
        for place, name in self._of_inputs:
            shown[place] = inputs[name]
        shown[self._count :] = displacements(self._machine, pose)
        if self._showing:
            self._disturb(shown, states, time_s)
        return pose, shown

    def _disturb(self, shown: FloatArray, states: FloatArray, time_s: float) -> None:
        """Let the effects that act on sensors change the readings."""
        table = {name: value[None, None] for name, value in zip(self.names, shown, strict=True)}
        time = np.array([time_s])
        for effect, part in self._showing:
            own = states[None, None, part]
            effect.reading(self._inputs, own, time, table)
        shown[:] = [float(table[name][0, 0]) for name in self.names]


def drift_of(pose: Sequence[float], length_mm: float) -> Drift:
    """Return what `structure.drift_at` returns, for one pose and one length [um]."""
    x, y, elongation, yaw, pitch, strain = pose
    lever = length_mm * UM_PER_MM
    tan_yaw, tan_pitch = math.tan(yaw * RAD_PER_URAD), math.tan(pitch * RAD_PER_URAD)
    tilt_squared = tan_yaw**2 + tan_pitch**2
    secant = math.sqrt(1.0 + tilt_squared)
    shortening = lever * tilt_squared / (secant * (1.0 + secant))
    return (
        x + lever * tan_yaw,
        y + lever * tan_pitch,
        shortening - elongation - strain * length_mm,
    )


def displacements(machine: Machine, pose: Sequence[float]) -> list[float]:
    """Return what `sensors.displacements` returns, for one pose, in the rig's order [um]."""
    rig, signs = machine.rig, machine.signs.values()
    if rig["kind"] == "direct":
        drift = drift_of(pose, 0.0)
        seen = [drift["XYZ".index(axis)] for axis in machine.probes.values()]
    else:
        near = rig["near_to_gauge_mm"]
        pairs = drift_of(pose, near)[:2], drift_of(pose, near + rig["spacing_mm"])[:2]
        seen = [*pairs[0], *pairs[1], drift_of(pose, rig["test_bar_mm"])[2]]
    return [sign * drift for sign, drift in zip(signs, seen, strict=True)]


def _has(effect: Effect, hook: str) -> bool:
    """Return whether an effect has a hook of its own."""
    return getattr(type(effect), hook) is not getattr(Effect, hook)
