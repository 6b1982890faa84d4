"""Stepping a network at one level of the inputs that its conductances use."""

from __future__ import annotations

import numpy as np

from plant_model.integrate import Modes, linear_steps
from plant_model.network import Network
from plant_model.parameters import FloatArray

Held = dict[str, FloatArray]
Ends = tuple[FloatArray, FloatArray]
"""A quantity at the start and at the end of a step, linear between."""


class LevelStepper:
    """What stepping needs to know of one level; it steps where nothing depends on temperature.

    Parameters
    ----------
    network : Network
    matrix : array, shape (sets or 1, nodes, nodes)
        Its conductances L at this level [W/K].
    boundary : array, shape (sets or 1, nodes, boundaries)
        Those to boundary temperatures, B [W/K].

    Attributes
    ----------
    modes : Modes
    """

    def __init__(self, network: Network, matrix: FloatArray, boundary: FloatArray) -> None:
        self.network, self._boundary = network, boundary
        self._names = list(network.machine.boundary_index)
        if network.linear:
            self.modes = Modes.of(matrix, network.capacity)
        else:
            modes = Modes.of(matrix, network.capacity, network.state_count)
            # What own states lose by themselves is stepped exactly: a small holder or a quick lag
            # would otherwise ask for steps as short as its time constant.
            self.modes = modes.with_state_decay(network.state_decay())

    def forced(self, heat: Ends, outside: Ends) -> Ends:
        """Return what heat does at the start and the end of each step, (sets, K, size) in modes.

        Parameters
        ----------
        heat : pair of array, shape (sets, K, nodes)
            From inputs [W].
        outside : pair of array, shape (K, boundaries)
            Boundary temperatures [degC].
        """
        first = last = self._forced(heat[0], outside[0])
        # Where a master holds all inputs both ends are one array.
        if heat[1] is not heat[0] or outside[1] is not outside[0]:
            last = self._forced(heat[1], outside[1])
        return first, last

    def _forced(self, heat: FloatArray, outside: FloatArray) -> FloatArray:
        force = heat + np.einsum("snb,kb->skn", self._boundary, outside)
        nodes = self.network.node_count
        to_modes = np.swapaxes(self.modes.to_modes[:, :nodes, :nodes], 1, 2)
        in_modes = np.matmul(force / self.network.capacity[:, None, :], to_modes)
        states = self.modes.decay.shape[1] - nodes
        return np.pad(in_modes, ((0, 0), (0, 0), (0, states))) if states else in_modes

    def exact(
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
        network, modes = self.network, self.modes
        nodes = network.node_count
        first, last = self.forced(heat, outside)
        before = np.matmul(modes.to_modes, start[:, :nodes, None])[..., 0]
        ends = linear_steps(modes, before, steps, first, last)
        after = np.matmul(ends, np.swapaxes(modes.to_state, 1, 2))
        if not network.state_count:
            return np.asarray(after)
        begun = np.concatenate([start[:, None, :nodes], after[:, :-1]], axis=1)
        at_start, at_end = (held | dict(zip(self._names, u.T, strict=True)) for u in outside)
        own = network.followed(start[:, nodes:], steps, (at_start, begun), (at_end, after))
        return np.concatenate([after, own], axis=2)
