"""One machine stepped in time with held inputs, as by a co-simulation master."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from functools import lru_cache
from typing import Any

import numpy as np

from plant_model.axis import AxisOffset
from plant_model.instant import Instant, drift_of
from plant_model.integrate import TOLERANCE
from plant_model.level import LevelStepper
from plant_model.machine import Machine
from plant_model.network import Network, effects_in_force
from plant_model.noise import NormalSequence
from plant_model.parameters import FloatArray, Values
from plant_model.rest import RestingParts
from plant_model.sensors import SensorNoise
from plant_model.side_by_side import Track, side_by_side

AXES = ("X", "Y", "Z")
OFFSETS = tuple(f"d{axis}" for axis in AXES)
AXIS_OUTPUTS = tuple((f"drift_{axis}", f"offset_{axis}", f"error_{axis}") for axis in AXES)


class InputError(ValueError):
    """An input that is not finite or outside the range that the machine file gives it."""


class PlantStepper:
    """A machine with inputs held during each step; exact if the network is linear.

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
        self._instant = Instant(machine, self.effects, self.network.state_slices())
        self._names = [entry.name for entry in machine.inputs]
        self._boundaries = list(machine.boundary_index)
        self._held = [name for name in self._names if name not in machine.boundary_index]
        self._ranges = [(entry.name, entry.low, entry.high) for entry in machine.inputs]
        self._seed = noise_seed
        self._noise = SensorNoise(machine)
        self._normal = NormalSequence(noise_seed or 0, len(self._noise.names))
        self._axes = [AxisOffset(machine.axis) for _ in AXES]
        self._level_at, self._heat_at = lru_cache(self._level), lru_cache(self._heat)
        # With the file's parameters, as in C: solving the network is not a formula to trace.
        rests = any(node.rests for node in machine.nodes)
        self._resting = RestingParts.of(machine) if rests else None
        self._outputs: dict[str, float] = {}
        self.reset({entry.name: entry.default or 0.0 for entry in machine.inputs})

    def reset(
        self, inputs: Mapping[str, float], readings: Mapping[str, float] | None = None
    ) -> None:
        """Restart: every node at the first value of its input or sensor.

        Parameters
        ----------
        inputs : mapping of str to float
            Inputs at the start, and ``tool_length`` [mm] if a tool is measured.
        readings : mapping of str to float, optional
            First readings of sensors by name [degC]; the first boundary temperature replaces
            missing ones.
        """
        names = self.machine.boundary_index
        first = inputs[next(iter(names))]
        signals = dict(readings or {}) | {name: inputs[name] for name in names}
        self._start = np.array([node.starts_at(signals, first) for node in self.machine.nodes])
        if self._resting:
            boundary = np.array([inputs[name] for name in names])
            self._start = self._resting.filled(self._start[None], boundary)[0]
        own = self.network.start_states(self._start[None], _arrays(inputs, self._names))
        self._state = np.concatenate([self._start, own[0]])
        self._time = 0.0
        self._normal.drawn = 0
        self._part = 1.0
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
            The machine's inputs by name, and ``tool_length`` [mm] and the offsets received ``dX``,
            ``dY``, ``dZ`` [um], which are zero if absent.

        Raises
        ------
        ValueError
            For a step that is not finite and above 0; :class:`InputError` for an input out of
            range.
        """
        if not 0.0 < step_s < math.inf:
            raise ValueError(f"a step of {step_s:g} s: it must be above 0 and finite")
        self._check(inputs)
        self._state = self._advanced(step_s, inputs)
        self._time += step_s
        for axis, name in zip(self._axes, OFFSETS, strict=True):
            axis.step(inputs.get(name, 0.0), step_s)
        self._refresh(inputs)

    def _check(self, inputs: Mapping[str, float]) -> None:
        for place, (name, low, high) in enumerate(self._ranges):
            value = inputs[name]
            if not low <= value <= high:
                unit = self.machine.inputs[place].unit
                raise InputError(f"{name}: {value:g} is outside {low:g}..{high:g} {unit}")

    def _advanced(self, step_s: float, inputs: Mapping[str, float]) -> FloatArray:
        level = self._level_at(tuple([inputs[n] for n in self.network.conductance_inputs]))
        # Heat from boundary temperatures is an exchange, so only held inputs matter.
        heat = self._heat_at(tuple([inputs[name] for name in self._held]))
        boundary = np.array([[inputs[name] for name in self._boundaries]])
        held, outside = _arrays(inputs, self._names), (boundary, boundary)
        state, steps = self._state[None], np.array([step_s])
        if self.network.linear:
            end: FloatArray = level.exact(state, steps, held, (heat, heat), outside)[0, 0]
            return end
        force = level.forced((heat, heat), outside)
        track = Track(state, steps, [level], held, force, outside, self._part)
        end = side_by_side(self.network, [track], TOLERANCE)[0][0, 0]
        self._part = track.part
        return end

    def _level(self, values: tuple[float, ...]) -> LevelStepper:
        given = self._given(self.network.conductance_inputs, values)
        return LevelStepper(self.network, *self.network.conductances(given))

    def _heat(self, values: tuple[float, ...]) -> FloatArray:
        return self.network.heat(self._given(self._held, values))

    def _given(self, names: Iterable[str], values: tuple[float, ...]) -> dict[str, FloatArray]:
        """Return some inputs, and 0 for the others."""
        given = dict.fromkeys(self._names, 0.0) | dict(zip(names, values, strict=True))
        return _arrays(given, self._names)

    def _refresh(self, inputs: Mapping[str, float]) -> None:
        """Compute all outputs for the present state."""
        pose, shown = self._instant.at(self._state, self._start, inputs, self._time)
        outputs = dict(zip(self._instant.names, shown.tolist(), strict=True))
        if self._seed is not None:
            exact = dict(zip(self._instant.names, shown[:, None, None], strict=True))
            noisy = self._noise.added(exact, self._normal.draw()[:, None, None])
            outputs = {name: float(noisy[name][0, 0]) for name in outputs}
        drift = drift_of(pose, inputs.get("tool_length", 0.0))
        for axis, (out, moved, left), value in zip(self._axes, AXIS_OUTPUTS, drift, strict=True):
            outputs[out] = value
            outputs[moved] = offset = axis.in_force
            outputs[left] = value + offset
        self._outputs = outputs

    def outputs(self) -> dict[str, float]:
        """Return readings [degC, um], tool-tip drift, offsets in force, remaining errors [um]."""
        return self._outputs

    def state(self) -> dict[str, Any]:
        """Return the state needed to continue, ready for JSON."""
        return {
            "time": self._time,
            "start": self._start.tolist(),
            "state": self._state.tolist(),
            "axes": [axis.state() for axis in self._axes],
            "drawn": self._normal.drawn,
            "part": self._part,
            "outputs": self._outputs,
        }

    def restore(self, state: dict[str, Any]) -> None:
        """Continue exactly from :meth:`state`."""
        self._time = state["time"]
        self._start = np.array(state["start"])
        self._state = np.array(state["state"])
        for axis, part in zip(self._axes, state["axes"], strict=True):
            axis.restore(part)
        self._normal.drawn = state["drawn"]
        self._part = state["part"]
        self._outputs = dict(state["outputs"])


def _arrays(inputs: Mapping[str, float], names: Iterable[str]) -> dict[str, FloatArray]:
    """Return inputs in the form that hooks of effects take, each of shape (1,)."""
    return {name: np.array([inputs[name]]) for name in names}
