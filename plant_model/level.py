"""Stepping a network at one level of the inputs that its conductances use."""

from __future__ import annotations

import numpy as np

from plant_model.integrate import Modes, apply, linear_steps
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
    matrix : array, shape (sets, nodes, nodes)
        Its conductances L at this level [W/K].
    boundary : array, shape (sets, nodes, boundaries)
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
        """Return the heat from inputs and boundaries at the start and the end of each step [W].

        Parameters
        ----------
        heat : pair of array, shape (sets, K, nodes)
            From inputs [W].
        outside : pair of array, shape (K, boundaries)
            Boundary temperatures [degC].
        """
        first = heat[0] + np.einsum("snb,kb->skn", self._boundary, outside[0])
        # Where a master holds all inputs both ends are one array.
        last = first
        if heat[1] is not heat[0] or outside[1] is not outside[0]:
            last = heat[1] + np.einsum("snb,kb->skn", self._boundary, outside[1])
        return first, last

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
        force = self.forced(heat, outside)
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
