"""Stepping a network at one level of the inputs that its conductances use."""

from __future__ import annotations

from functools import cached_property

import numpy as np

from plant_model.integrate import Modes, linear_steps
from plant_model.network import Network
from plant_model.parameters import FloatArray

Held = dict[str, FloatArray]
Ends = tuple[FloatArray, FloatArray]
"""A quantity at the start and at the end of a step, linear in between."""


class LevelStepper:
    """Steps the network at one level of the inputs, exactly if nothing depends on temperature.

    Parameters
    ----------
    network : Network
    matrix : array, shape (sets or 1, nodes, nodes)
        Conductances L at this level [W/K].
    boundary : array, shape (sets or 1, nodes, boundaries)
        Conductances B to boundary temperatures [W/K].

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
            # The own decay of own states is stepped exactly: a small holder or a quick lag
            # would otherwise require steps as short as its time constant.
            self.modes = modes.with_state_decay(network.state_decay())

    def forced(self, heat: Ends, outside: Ends) -> Ends:
        """Return the forcing in modes at the start and the end of each step, (sets, K, size).

        Parameters
        ----------
        heat : pair of array, shape (sets, K, nodes)
            Heat from inputs [W].
        outside : pair of array, shape (K, boundaries)
            Boundary temperatures [degC].
        """
        first = last = heat[0] @ self._by_heat
        if heat[1] is not heat[0]:
            last = heat[1] @ self._by_heat
        # If a master holds all inputs, both ends are one array.
        alike = last is first and outside[1] is outside[0]
        first = first + outside[0] @ self._by_boundary
        return first, first if alike else last + outside[1] @ self._by_boundary

    @cached_property
    def _by_heat(self) -> FloatArray:
        """Forcing of the (orthogonal) modes by 1 W in a node, (sets, nodes, size) [K/J]."""
        return self.modes.to_state[:, : self.network.node_count]

    @cached_property
    def _by_boundary(self) -> FloatArray:
        """Forcing of the modes by 1 K at a boundary, (sets, boundaries, size) [1/s]."""
        return np.asarray(np.swapaxes(self._boundary, 1, 2) @ self._by_heat)

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
            Inputs that are constant in each step.
        heat : pair of array, shape (sets, K, nodes)
            Heat from inputs at the start and the end of each step [W].
        outside : pair of array, shape (K, boundaries)
            Boundary temperatures then [degC].
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
