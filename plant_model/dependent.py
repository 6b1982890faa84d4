"""Stepping a network in which something depends on temperature."""

from __future__ import annotations

import numpy as np

from plant_model.integrate import TOLERANCE, ExponentialRungeKutta, Modes, apply
from plant_model.network import Network
from plant_model.parameters import FloatArray

Ends = tuple[FloatArray, FloatArray]
"""A quantity at the start and at the end of a step, linear between."""


class DependentStepper:
    """Steps temperatures and own states through intervals of one set of conductances.

    Parameters
    ----------
    network : Network
    modes : Modes
        Of the network's linear part, own states appended.
    tolerance : float
        Local error allowed [K].
    """

    def __init__(self, network: Network, modes: Modes, tolerance: float = TOLERANCE) -> None:
        self.network = network
        # What own states lose by themselves is stepped exactly: a small holder or a quick lag would
        # otherwise ask for steps as short as its time constant.
        self._decay = network.state_decay()
        self.modes = modes if network.linear else modes.with_state_decay(self._decay)
        self._scheme = ExponentialRungeKutta(self.modes, tolerance, network.error_scale)

    @property
    def part(self) -> float:
        """The part of an interval that error control goes at a time [1]."""
        return self._scheme.part

    @part.setter
    def part(self, value: float) -> None:
        self._scheme.part = value

    def advance(
        self,
        state: FloatArray,
        length: float,
        held: dict[str, FloatArray],
        force: Ends,
        boundary: Ends,
    ) -> FloatArray:
        """Return [temperatures, own states], shape (sets, size), one interval later.

        Parameters
        ----------
        state : array, shape (sets, size)
        length : float
            Of the interval [s].
        held : dict of str to array, shape (1,)
            Inputs that stay.
        force : pair of array, shape (sets, nodes)
            Heat from inputs and boundaries at the start and the end [W].
        boundary : pair of array, shape (boundaries,)
            Boundary temperatures at the start and the end [degC].
        """
        network, modes = self.network, self.modes
        nodes = network.node_count
        names = list(network.machine.boundary_index)

        def forcing(at: float, in_modes: FloatArray) -> FloatArray:
            now = apply(modes.to_state, in_modes)[:, None, :]
            outside = (boundary[0] + at * (boundary[1] - boundary[0]))[None, :]
            inputs = held | {name: outside[:, i] for i, name in enumerate(names)}
            heat, rates = network.dependent(inputs, outside, now[..., :nodes], now[..., nodes:])
            known = force[0] + at * (force[1] - force[0])
            rates = rates[:, 0] + self._decay * now[:, 0, nodes:]
            rate = np.concatenate([(known + heat[:, 0]) / network.capacity, rates], axis=1)
            return apply(modes.to_modes, rate)

        at_end = self._scheme.interval(apply(modes.to_modes, state), length, forcing)
        end = apply(modes.to_state, at_end)
        if network.settles:
            end[:, nodes:] = network.settled(held, end[:, :nodes], end[:, nodes:])
        return end
