"""One machine stepped in time with held inputs, as a co-simulation master drives it."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any

import numpy as np

from plant_model.axis import AxisOffset
from plant_model.dependent import DependentStepper
from plant_model.integrate import Modes, apply, phi
from plant_model.machine import Machine
from plant_model.network import Network, effects_in_force
from plant_model.parameters import FloatArray, Values
from plant_model.sensors import SensorNoise, readings
from plant_model.structure import drift_at, pose

AXES = ("X", "Y", "Z")

KEPT = 64
"""Propagators, and heats of input values, kept at once."""


class InputError(ValueError):
    """An input that is not finite or outside the range that the machine file gives it."""


class PlantStepper:
    """A machine whose inputs hold during each step; exact where the network is linear.

    Parameters
    ----------
    machine : Machine
    parameters : mapping of str to float, optional
        Values to use instead of the machine's.
    noise_seed : int, optional
        Adds sensor noise and resolution; the same seed gives the same noise.

    Raises
    ------
    ParameterError
        For an unknown parameter or a value outside its range.
    """

    def __init__(
        self,
        machine: Machine,
        parameters: Mapping[str, float] | None = None,
        noise_seed: int | None = None,
    ) -> None:
        values = Values(machine.parameters, parameters)
        self.machine = machine
        self.effects = effects_in_force(machine, values)
        self.network = Network(machine, values, self.effects)
        self._slices = self.network.state_slices()
        self._names = [entry.name for entry in machine.inputs]
        self._seed = noise_seed
        self._noise = SensorNoise(machine, noise_seed)
        self._axes = [AxisOffset(machine.axis) for _ in AXES]
        self._modes: dict[tuple[float, ...], tuple[Modes, FloatArray, DependentStepper]] = {}
        self._linear: dict[tuple[float, ...], tuple[FloatArray, FloatArray]] = {}
        self._heat: dict[tuple[float, ...], FloatArray] = {}
        self._outputs: dict[str, float] = {}
        self.reset({entry.name: entry.default or 0.0 for entry in machine.inputs})

    def reset(
        self, inputs: Mapping[str, float], readings: Mapping[str, float] | None = None
    ) -> None:
        """Start again: every node at the first value of the input or sensor it starts at.

        Parameters
        ----------
        inputs : mapping of str to float
            Inputs at the start; ``tool_length`` [mm] too where a tool is measured.
        readings : mapping of str to float, optional
            First readings of sensors by name [degC]; of those that are not there, the first
            boundary temperature is taken.
        """
        names = self.machine.boundary_index
        first = inputs[next(iter(names))]
        known = dict(readings or {}) | {name: inputs[name] for name in names}
        self._start = np.array([[known.get(node.start, first) for node in self.machine.nodes]])
        arrays = {name: np.array([inputs[name]]) for name in self._names}
        own = self.network.start_states(self._start, arrays)
        self._state = np.concatenate([self._start, own], axis=1)
        self._time = 0.0
        self._noise = SensorNoise(self.machine, self._seed)
        for axis in self._axes:
            axis.restore([0.0, 0.0])
        self._refresh(inputs)

    def step(self, step_s: float, inputs: Mapping[str, float]) -> None:
        """Advance by *step_s* with inputs held.

        Parameters
        ----------
        step_s : float
            Length of the step [s].
        inputs : mapping of str to float
            The machine's inputs by name; ``tool_length`` [mm] and the offsets received ``dX``,
            ``dY``, ``dZ`` [um], zero where absent.

        Raises
        ------
        ValueError
            For a step that is not positive; :class:`InputError` for an input out of range.
        """
        if not step_s > 0.0:
            raise ValueError(f"a step of {step_s:g} s: it must be above 0")
        self._check(inputs)
        self._state = self._advanced(step_s, inputs)
        self._time += step_s
        for axis, name in zip(self._axes, AXES, strict=True):
            axis.step(inputs.get(f"d{name}", 0.0), step_s)
        self._refresh(inputs)

    def _check(self, inputs: Mapping[str, float]) -> None:
        for entry in self.machine.inputs:
            value = inputs[entry.name]
            if not entry.low <= value <= entry.high:
                raise InputError(
                    f"{entry.name}: {value:g} is outside {entry.low:g}..{entry.high:g} {entry.unit}"
                )

    def _advanced(self, step_s: float, inputs: Mapping[str, float]) -> FloatArray:
        network = self.network
        level = tuple(inputs[name] for name in network.conductance_inputs)
        modes, boundary, stepper = self._modes_at(level)
        outside = np.array([inputs[name] for name in self.machine.boundary_index])
        force = self._heat_at(inputs) + boundary @ outside
        held = {name: np.array([inputs[name]]) for name in self._names}
        if network.linear:
            keep, gain = self._propagator(level, step_s, modes)
            before = self._state[:, : network.node_count]
            after = apply(keep, before) + apply(gain, force)
            if not network.state_count:
                return after
            ends = (held, before[:, None]), (held, after[:, None])
            own = self._state[:, network.node_count :]
            followed = network.followed(own, np.array([step_s]), *ends)[:, 0]
            return np.concatenate([after, followed], axis=1)
        between = (force, force), (outside, outside)
        return stepper.advance(self._state, step_s, held, *between)

    def _modes_at(self, level: tuple[float, ...]) -> tuple[Modes, FloatArray, DependentStepper]:
        known = self._modes.get(level)
        if known is None:
            network = self.network
            inputs = {name: np.zeros(1) for name in self._names}
            for name, value in zip(network.conductance_inputs, level, strict=True):
                inputs[name] = np.array([value])
            matrix, boundary = network.conductances(inputs)
            with_states = 0 if network.linear else network.state_count
            modes = Modes.of(matrix, network.capacity, with_states)
            known = (modes, boundary, DependentStepper(network, modes))
            _keep(self._modes, level, known)
        return known

    def _heat_at(self, inputs: Mapping[str, float]) -> FloatArray:
        key = tuple(inputs[name] for name in self._names)
        known = self._heat.get(key)
        if known is None:
            arrays = {name: np.array([value]) for name, value in zip(self._names, key, strict=True)}
            known = self.network.heat(arrays)[:, 0]
            _keep(self._heat, key, known)
        return known

    def _propagator(
        self, level: tuple[float, ...], step_s: float, modes: Modes
    ) -> tuple[FloatArray, FloatArray]:
        """Return the matrices of T(t + h) = K T(t) + G f for forcing f [W] held in the step."""
        key = (*level, step_s)
        known = self._linear.get(key)
        if known is None:
            x = -modes.decay * step_s
            keep = (modes.to_state * np.exp(x)[:, None, :]) @ modes.to_modes
            gain = (modes.to_state * (step_s * phi(1, x))[:, None, :]) @ modes.to_modes
            known = (keep, gain / self.network.capacity[:, None, :])
            _keep(self._linear, key, known)
        return known

    def _refresh(self, inputs: Mapping[str, float]) -> None:
        """Compute all outputs for the state as it is."""
        nodes = self.network.node_count
        temperatures = self._state[:, None, :nodes]
        states = self._state[:, None, nodes:]
        arrays = {name: np.array([inputs[name]]) for name in self._names}
        rise = temperatures - self._start[:, None, :]
        pose_now = pose(self.effects, self._slices, arrays, rise, states)
        time = np.array([self._time])
        shown = readings(
            self.machine, self.effects, self._slices, arrays, time, temperatures, states, pose_now
        )
        if self._seed is not None:
            shown = self._noise.added(shown)
        outputs = {name: float(value[0, 0]) for name, value in shown.items()}
        drift = drift_at(pose_now[0, 0], inputs.get("tool_length", 0.0))
        for axis, name, value in zip(self._axes, AXES, drift.tolist(), strict=True):
            outputs[f"drift_{name}"] = value
            outputs[f"offset_{name}"] = axis.in_force
            outputs[f"error_{name}"] = value + axis.in_force
        self._outputs = outputs

    def outputs(self) -> dict[str, float]:
        """Return readings [degC, um], tool-tip drift, offsets in force and errors left [um]."""
        return self._outputs

    def state(self) -> dict[str, Any]:
        """Return everything that a continued trajectory needs, ready for JSON."""
        return {
            "time": self._time,
            "start": self._start[0].tolist(),
            "state": self._state[0].tolist(),
            "axes": [axis.state() for axis in self._axes],
            "noise": json.dumps(self._noise.generator.bit_generator.state),
            "outputs": self._outputs,
        }

    def restore(self, state: dict[str, Any]) -> None:
        """Continue exactly from :meth:`state`."""
        self._time = state["time"]
        self._start = np.array([state["start"]])
        self._state = np.array([state["state"]])
        for axis, part in zip(self._axes, state["axes"], strict=True):
            axis.restore(part)
        self._noise.generator.bit_generator.state = json.loads(state["noise"])
        self._outputs = dict(state["outputs"])


def _keep(known: dict[Any, Any], key: Any, value: Any) -> None:
    """Remember a result, forgetting the oldest when there are many."""
    if len(known) >= KEPT:
        known.pop(next(iter(known)))
    known[key] = value
