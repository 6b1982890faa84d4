"""Stepping a network at one level of the inputs that its conductances use."""

from __future__ import annotations

import numpy as np

from plant_model.integrate import TOLERANCE, ExponentialRungeKutta, Modes, apply, linear_steps
from plant_model.network import Network
from plant_model.parameters import FloatArray

Held = dict[str, FloatArray]
Ends = tuple[FloatArray, FloatArray]
"""A quantity at the start and at the end of a step, linear between."""


class LevelStepper:
    """Steps temperatures and own states, exactly where nothing depends on temperature.

    Parameters
    ----------
    network : Network
    matrix : array, shape (sets, nodes, nodes)
        Its conductances L at this level [W/K].
    boundary : array, shape (sets, nodes, boundaries)
        Those to boundary temperatures, B [W/K].
    tolerance : float
        Local error allowed where a step is not exact [K].
    """

    def __init__(
        self,
        network: Network,
        matrix: FloatArray,
        boundary: FloatArray,
        tolerance: float = TOLERANCE,
    ) -> None:
        self.network, self._boundary = network, boundary
        self._names = list(network.machine.boundary_index)
        # What own states lose by themselves is stepped exactly: a small holder or a quick lag would
        # otherwise ask for steps as short as its time constant.
        self._decay = network.state_decay()
        if network.linear:
            self.modes = Modes.of(matrix, network.capacity)
        else:
            modes = Modes.of(matrix, network.capacity, network.state_count)
            self.modes = modes.with_state_decay(self._decay)
        self._scheme = ExponentialRungeKutta(self.modes, tolerance, network.error_scale)

    @property
    def part(self) -> float:
        """The part of a step that error control goes at a time [1]."""
        return self._scheme.part

    @part.setter
    def part(self, value: float) -> None:
        self._scheme.part = value

    def through(
        self, start: FloatArray, steps: FloatArray, held: Held, heat: Ends, outside: Ends
    ) -> FloatArray:
        """Return [temperatures, own states] at the end of each step, shape (sets, K, size).

        Parameters
        ----------
        start : array, shape (sets, size)
        steps : array, shape (K,)
            Their lengths [s].
        held : dict of str to array, shape (K,)
            Inputs that stay in each step.
        heat : pair of array, shape (sets, K, nodes)
            From inputs, at the start and the end of each step [W].
        outside : pair of array, shape (K, boundaries)
            Boundary temperatures there [degC].
        """
        first = heat[0] + np.einsum("snb,kb->skn", self._boundary, outside[0])
        # Where a master holds all inputs both ends are one array.
        last = first
        if heat[1] is not heat[0] or outside[1] is not outside[0]:
            last = heat[1] + np.einsum("snb,kb->skn", self._boundary, outside[1])
        if self.network.linear:
            return self._exact(start, steps, held, (first, last), outside)
        out = np.empty((len(start), len(steps), start.shape[1]))
        for k, length in enumerate(steps.tolist()):
            now = {name: values[k : k + 1] for name, values in held.items()}
            ends = (first[:, k], last[:, k]), (outside[0][k], outside[1][k])
            start = out[:, k] = self._dependent(start, length, now, *ends)
        return out

    def _exact(
        self, start: FloatArray, steps: FloatArray, held: Held, force: Ends, outside: Ends
    ) -> FloatArray:
        network, modes = self.network, self.modes
        nodes = network.node_count
        to_modes = np.swapaxes(modes.to_modes, 1, 2)
        capacity = network.capacity[:, None, :]
        first = last = np.matmul(force[0] / capacity, to_modes)
        if force[1] is not force[0]:
            last = np.matmul(force[1] / capacity, to_modes)
        before = apply(modes.to_modes, start[:, :nodes])
        ends = linear_steps(modes, before, steps, first, last)
        after = np.matmul(ends, np.swapaxes(modes.to_state, 1, 2))
        if not network.state_count:
            return np.asarray(after)
        begun = np.concatenate([start[:, None, :nodes], after[:, :-1]], axis=1)
        at_start, at_end = (held | dict(zip(self._names, u.T, strict=True)) for u in outside)
        own = network.followed(start[:, nodes:], steps, (at_start, begun), (at_end, after))
        return np.concatenate([after, own], axis=2)

    def _dependent(
        self, state: FloatArray, length: float, held: Held, force: Ends, outside: Ends
    ) -> FloatArray:
        """Return [temperatures, own states], shape (sets, size), one step later.

        Forces are (sets, nodes) [W], boundary temperatures (boundaries,) [degC].
        """
        network, modes = self.network, self.modes
        nodes = network.node_count

        def forcing(at: float, in_modes: FloatArray) -> FloatArray:
            now = apply(modes.to_state, in_modes)[:, None, :]
            around = (outside[0] + at * (outside[1] - outside[0]))[None, :]
            inputs = held | {name: around[:, i] for i, name in enumerate(self._names)}
            heat, rates = network.dependent(inputs, around, now[..., :nodes], now[..., nodes:])
            known = force[0] + at * (force[1] - force[0])
            rates = rates[:, 0] + self._decay * now[:, 0, nodes:]
            rate = np.concatenate([(known + heat[:, 0]) / network.capacity, rates], axis=1)
            return apply(modes.to_modes, rate)

        at_end = self._scheme.interval(apply(modes.to_modes, state), length, forcing)
        end = apply(modes.to_state, at_end)
        if network.settles:
            end[:, nodes:] = network.settled(held, end[:, :nodes], end[:, nodes:])
        return end
