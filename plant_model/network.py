"""The thermal network: effects in force, assembled into matrices and heat.

C dT/dt = -L(inputs) T + B(inputs) u + q, with capacities C [J/K], conductances L and B [W/K],
boundary temperatures u [degC] and heat q [W]. Everything that depends on temperature is in q.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np

from plant_model.effects import Effect, catalogue
from plant_model.effects.base import NONE, Inputs
from plant_model.exchange import Exchange
from plant_model.integrate import TOLERANCE, Modes, linear_steps
from plant_model.machine import Machine
from plant_model.parameters import FloatArray, Values

FLOWING_K = 0.1
"""Largest local error of a part that another part's coolant flows into [K], given by the resolution
of a thermometer: the next coolant takes it away within seconds. On a machining centre with jackets
in series, outside this project, no temperature of a run is off by more than 0.016 K."""


def effects_in_force(machine: Machine, values: Values) -> list[Effect]:
    """Return the machine's effects without those that are off in every parameter set.

    Parameters
    ----------
    machine : Machine
    values : Values
        The parameter sets.
    """
    effects = []
    for key in machine.effects:
        name, _, channel = key.partition(":")
        effect = catalogue()[name]
        if not values.is_off(f"effects.{key}.{effect.amplitude}", effect.off):
            effects.append(effect(machine, values, channel))
    return effects


def state_slices(effects: Sequence[Effect]) -> dict[str, slice]:
    """Return the positions of each effect's own states, by its key.

    Parameters
    ----------
    effects : sequence of Effect
        Those in force, in their order.
    """
    slices, at = {}, 0
    for effect in effects:
        if effect.states:
            slices[effect.key] = slice(at, at + len(effect.states))
            at += len(effect.states)
    return slices


class Network:
    """The heat side of a machine for one or many parameter sets.

    Parameters
    ----------
    machine : Machine
    values : Values
        The parameter sets.
    effects : sequence of Effect
        In force, as `effects_in_force` gives them.

    Attributes
    ----------
    capacity : array, shape (sets or 1, nodes)
        Heat capacities [J/K]; "or 1" here and below: one set if all sets have the same values.
    linear : bool
        Whether nothing depends on temperature, so that stepping is exact; own states then only
        follow (:meth:`followed`).
    error_scale : array, shape (nodes + own states,)
        Error that counts as much as 1 K in error control.
    settles : bool
        Whether own states jump at the end of a step (:meth:`settled`).
    state_count : int
        Number of the effects' own states.
    one_way : list of Exchange
        Heat that a flow carries from one node to another.
    """

    def __init__(self, machine: Machine, values: Values, effects: Sequence[Effect]) -> None:
        self.machine = machine
        self.sets = values.sets
        self.node_count = len(machine.nodes)
        self.boundary_count = len(machine.boundary_index)
        columns = [values[f"nodes.{node.name}.capacity"] for node in machine.nodes]
        self.capacity = np.concatenate(np.broadcast_arrays(*columns), axis=1)
        self._effects = effects
        self._plain = [effect for effect in effects if not effect.temperature_dependent]
        self._dependent = [effect for effect in effects if effect.temperature_dependent]
        self._with_states = [effect for effect in effects if effect.states]
        self.state_count = sum(len(effect.states) for effect in self._with_states)
        self.conductance_inputs = sorted(
            {name for effect in self._plain for name in effect.conductance_inputs}
        )
        probe = {entry.name: np.array([0.0]) for entry in machine.inputs}
        # Heat that a flow brings from another node is not symmetric.
        self.one_way = [
            entry for entry in self.exchanges(probe) if entry.one_way and not entry.boundary
        ]
        follow_only = all(effect.lags or effect.settles for effect in self._with_states)
        self.settles = any(effect.settles for effect in self._with_states)
        self.linear = follow_only and not (self._dependent or self.one_way)
        scales = [effect.state_scales or (1.0,) * len(effect.states) for effect in effects]
        self.error_scale = np.concatenate([np.ones(self.node_count), *scales])
        self.error_scale[[entry.node for entry in self.one_way]] = FLOWING_K / TOLERANCE
        self._slices = state_slices(effects)

    def exchanges(self, inputs: Inputs) -> Iterable[Exchange]:
        """Return the exchanges that depend on inputs only, at many sets of inputs at once."""
        for effect in self._effects:
            yield from effect.constant_exchanges
            if not effect.temperature_dependent:
                yield from effect.conductance(inputs, NONE, NONE)

    def conductances(self, inputs: Inputs) -> tuple[FloatArray, FloatArray]:
        """Return the symmetric matrix L and the boundary matrix B at one set of inputs.

        Parameters
        ----------
        inputs : mapping of str to array, shape (1,)
            The inputs; conductances use those in ``conductance_inputs``.

        Returns
        -------
        L : array, shape (sets or 1, nodes, nodes)
            Conductances between nodes, and on the diagonal to everything else [W/K].
        B : array, shape (sets or 1, nodes, boundaries)
            Conductances to the boundary temperatures [W/K].
        """
        matrix, boundary = self.all_conductances(inputs, 1)
        return matrix[:, 0], boundary[:, 0]

    def all_conductances(self, inputs: Inputs, levels: int) -> tuple[FloatArray, FloatArray]:
        """Return L and B at many sets of inputs at once, which costs little more than one set.

        Parameters
        ----------
        inputs : mapping of str to array, shape (levels,)
        levels : int

        Returns
        -------
        L : array, shape (sets or 1, levels, nodes, nodes)
        B : array, shape (sets or 1, levels, nodes, boundaries)
        """
        exchanges = list(self.exchanges(inputs))
        sets = max((entry.conductance.shape[0] for entry in exchanges), default=1)
        matrix = np.zeros((sets, levels, self.node_count, self.node_count))
        boundary = np.zeros((sets, levels, self.node_count, self.boundary_count))
        for entry in exchanges:
            g = entry.conductance
            matrix[:, :, entry.node, entry.node] += g
            if entry.boundary:
                boundary[:, :, entry.node, entry.other] += g
            elif not entry.one_way:
                matrix[:, :, entry.other, entry.other] += g
                matrix[:, :, entry.node, entry.other] -= g
                matrix[:, :, entry.other, entry.node] -= g
        return matrix, boundary

    def heat(self, inputs: Inputs) -> FloatArray:
        """Return the heat that depends on inputs only [W], shape (sets, times, nodes).

        Parameters
        ----------
        inputs : mapping of str to array, shape (times,)
        """
        times = max(np.size(value) for value in inputs.values())
        out = np.zeros((self.sets, times, self.node_count))
        for effect in self._plain:
            effect.heat(inputs, NONE, NONE, out)
        return out

    def dependent(
        self, inputs: Inputs, boundary: FloatArray, temperatures: FloatArray, states: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        """Return the heat that depends on temperature [W] and the rates of the own states.

        Parameters
        ----------
        inputs : mapping of str to array, shape (times,)
        boundary : array, shape (times, boundaries)
        temperatures : array, shape (sets, times, nodes)
        states : array, shape (sets, times, own states)

        Returns
        -------
        heat : array, shape (sets, times, nodes)
            [W]
        rates : array, shape (sets, times, own states)
            Each in its state's unit per second.
        """
        out = np.zeros(temperatures.shape)
        rates = np.zeros_like(states)
        for entry in self.one_way:
            out[..., entry.node] += entry.conductance * temperatures[..., entry.other]
        for effect in self._dependent:
            own = states[..., self._slices[effect.key]] if effect.states else NONE
            effect.heat(inputs, temperatures, own, out)
            for entry in effect.conductance(inputs, temperatures, own):
                other = (
                    boundary[None, :, entry.other]
                    if entry.boundary
                    else temperatures[..., entry.other]
                )
                flow = entry.conductance * (other - temperatures[..., entry.node])
                out[..., entry.node] += flow
                if not (entry.boundary or entry.one_way):
                    out[..., entry.other] -= flow
        for effect in self._with_states:
            if effect.settles:
                continue
            part = self._slices[effect.key]
            rates[..., part] = effect.rate(inputs, temperatures, states[..., part])
        return out, rates

    def state_slices(self) -> dict[str, slice]:
        """Return the positions of each effect's own states, by its key."""
        return self._slices

    def start_states(self, temperatures: FloatArray, inputs: Inputs) -> FloatArray:
        """Return the own states at the start, shape (sets, own states).

        Parameters
        ----------
        temperatures : array, shape (sets, nodes)
            [degC]
        inputs : mapping of str to array, shape (1,)
        """
        out = np.zeros((temperatures.shape[0], self.state_count))
        for effect in self._with_states:
            out[:, self._slices[effect.key]] = effect.start_states(temperatures, inputs)
        return out

    def state_decay(self) -> FloatArray:
        """Return the rates at which own states decay by themselves [1/s], (sets, own states)."""
        out = np.zeros((self.sets, self.state_count))
        for effect in self._with_states:
            out[:, self._slices[effect.key]] = effect.state_decay()
        return out

    def settled(self, inputs: Inputs, temperatures: FloatArray, states: FloatArray) -> FloatArray:
        """Return the own states after their jumps at the end of a step, (sets, own states).

        Parameters
        ----------
        inputs : mapping of str to array, shape (1,)
        temperatures : array, shape (sets, nodes)
            Of the nodes [degC].
        states : array, shape (sets, own states)
        """
        out = states.copy()
        for effect in self._with_states:
            if effect.settles:
                part = self._slices[effect.key]
                out[:, part] = effect.settled(inputs, temperatures, states[:, part])
        return out

    def followed(
        self,
        states: FloatArray,
        steps: FloatArray,
        first: tuple[Inputs, FloatArray],
        last: tuple[Inputs, FloatArray],
    ) -> FloatArray:
        """Return the own states of a linear network at the end of each step, exactly.

        Parameters
        ----------
        states : array, shape (sets, own states)
            At the start.
        steps : array, shape (K,)
            Lengths of the steps [s].
        first, last : inputs and temperatures
            At the start and the end of each step, shapes (K,) and (sets, K, nodes); the values
            that own states follow are taken as linear in between.
        """
        out = np.zeros((states.shape[0], len(steps), self.state_count))
        for effect in self._with_states:
            part = self._slices[effect.key]
            start = states[:, part]
            if effect.settles:
                for k in range(len(steps)):
                    now = {name: values[k : k + 1] for name, values in last[0].items()}
                    start = effect.settled(now, last[1][:, k], start)
                    out[:, k, part] = start
                continue
            decay = np.broadcast_to(1.0 / effect.time_constants(), start.shape)
            none = np.zeros((len(decay), 0, 0))
            ends = [
                np.broadcast_to(decay[:, None, :] * effect.target(*end), out[..., part].shape)
                for end in (first, last)
            ]
            out[..., part] = linear_steps(Modes(decay, none, none), start, steps, *ends)
        return out
