"""Start temperatures of parts without a thermometer: steady state of a machine long at rest.

A shaft, a ring or a test bar then has no net heat flow: 0 = sum_j G_ij (T_j - T_i) + q_i over its
neighbours j, some of which have a thermometer or are boundaries, with the conductances and the
heat of inputs at rest. A spindle between coolant at 21 degC and a hall at 24 degC is not at the
temperature of the thermometer next to it, and half a kelvin in a bar of 150 mm is 1 um.

Heat that depends on temperature is left out.
"""

from __future__ import annotations

from functools import cached_property

import numpy as np

from plant_model.machine import Input, Machine
from plant_model.network import Network, effects_in_force
from plant_model.parameters import FloatArray, Values

ISOLATED = 1e-9
"""Conductance to the first boundary, so that a part without exchange starts there [W/K]; given by
arithmetic: far above rounding, far below any exchange."""


def at_rest(entry: Input) -> float:
    """Return an input's value while the machine rests: its default or 0, clipped to its range."""
    return min(max(entry.default or 0.0, entry.low), entry.high)


class RestingParts:
    """Finds the start temperatures of the nodes with start ``rest`` in the machine file.

    Parameters
    ----------
    machine : Machine
    network : Network
        Of the machine, with the parameter sets to find starts for.

    Attributes
    ----------
    at, others : array of int
        Positions of the nodes that start at rest, and of all others.
    """

    def __init__(self, machine: Machine, network: Network) -> None:
        self._machine, self._network = machine, network
        rests = np.array([node.rests for node in machine.nodes], dtype=bool)
        self.at, self.others = np.flatnonzero(rests), np.flatnonzero(~rests)

    @classmethod
    def of(cls, machine: Machine) -> RestingParts:
        """Return it for the parameters of the machine file.

        Parameters
        ----------
        machine : Machine
        """
        values = Values(machine.parameters, None)
        return cls(machine, Network(machine, values, effects_in_force(machine, values)))

    @cached_property
    def weights(self) -> FloatArray:
        """Weights of all other nodes, then of the boundaries, then a constant in degC.

        Array, shape (sets, nodes at rest, other nodes + boundaries + 1).
        """
        inputs = {entry.name: np.array([at_rest(entry)]) for entry in self._machine.inputs}
        matrix, boundary = self._network.conductances(inputs)
        for entry in self._network.one_way:
            matrix[:, entry.node, entry.other] -= entry.conductance[:, 0]
        given = -matrix[:, self.at[:, None], self.others]
        # Heat of a part from which none gets away has no steady state.
        leads = matrix[:, self.at[:, None], self.at] != 0.0
        away = np.asarray(given.any(axis=2) | boundary[:, self.at].any(axis=2))
        for _ in self.at:
            away |= (leads & away[:, None]).any(axis=2)
        heat = (self._network.heat(inputs)[:, 0, self.at] * away)[..., None]
        matrix[:, self.at, self.at] += ISOLATED
        boundary[:, self.at, 0] += ISOLATED
        columns = (
            np.broadcast_to(part, (len(heat), *part.shape[1:]))
            for part in (given, boundary[:, self.at], heat)
        )
        right = np.concatenate([*columns], axis=2)
        return np.linalg.solve(matrix[:, self.at[:, None], self.at], right)

    def filled(self, starts: FloatArray, boundary: FloatArray) -> FloatArray:
        """Return the starts of all nodes [degC], shape (sets, nodes).

        Parameters
        ----------
        starts : array, shape (sets, nodes)
            The values of nodes at rest are replaced [degC].
        boundary : array, shape (boundaries,)
            Boundary temperatures at the start, in the machine's order [degC].
        """
        if not len(self.at):
            return starts
        out = starts.copy()
        ends = np.broadcast_to([*boundary, 1.0], (len(starts), len(boundary) + 1))
        given = np.concatenate([starts[:, self.others], ends], axis=1)
        out[:, self.at] = (self.weights @ given[:, :, None])[..., 0]
        return out
