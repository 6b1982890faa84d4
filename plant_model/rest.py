"""Where parts start that no thermometer reads: as a machine that has stood for long has them.

A shaft, a ring or a test bar then exchanges no heat on balance: 0 = sum_j G_ij (T_j - T_i) + q_i
over its neighbours j, of which thermometers and boundaries give some, with the conductances and the
heat of inputs at rest. A spindle between 21 degC of coolant and 24 degC of hall is not at the
temperature of the thermometer next to it, and half a kelvin in a bar of 150 mm is 1 um.

What depends on temperature has no part in it.
"""

from __future__ import annotations

from functools import cached_property

import numpy as np

from plant_model.machine import Input, Machine
from plant_model.network import Network, effects_in_force
from plant_model.parameters import FloatArray, Values

ISOLATED = 1e-9
"""A part that exchanges nothing stands at the first boundary: by so much to it [W/K], given by
arithmetic: far above the last digits, far below any exchange."""


def at_rest(entry: Input) -> float:
    """Return what an input is while the machine rests: its default, or as near to 0 as it goes."""
    return min(max(entry.default or 0.0, entry.low), entry.high)


class RestingParts:
    """Finds the start of the parts that the machine file starts at ``rest``.

    Parameters
    ----------
    machine : Machine
    network : Network
        Of the machine, for as many parameter sets as starts are wanted for.

    Attributes
    ----------
    at, others : array of int
        The nodes that start at rest, and all others.
    """

    def __init__(self, machine: Machine, network: Network) -> None:
        self._machine, self._network = machine, network
        rests = np.array([node.rests for node in machine.nodes], dtype=bool)
        self.at, self.others = np.flatnonzero(rests), np.flatnonzero(~rests)

    @classmethod
    def of(cls, machine: Machine) -> RestingParts:
        """Return it for the numbers that the machine file has.

        Parameters
        ----------
        machine : Machine
        """
        values = Values(machine.parameters, None)
        return cls(machine, Network(machine, values, effects_in_force(machine, values)))

    @cached_property
    def weights(self) -> FloatArray:
        """Shares of all other nodes, then of the boundaries, then a constant in degC.

        Array, shape (sets, nodes at rest, other nodes + boundaries + 1).
        """
        inputs = {entry.name: np.array([at_rest(entry)]) for entry in self._machine.inputs}
        matrix, boundary = self._network.conductances(inputs)
        for entry in self._network.one_way:
            matrix[:, entry.node, entry.other] -= entry.conductance[:, 0]
        matrix[:, self.at, self.at] += ISOLATED
        boundary[:, self.at, 0] += ISOLATED
        heat = self._network.heat(inputs)[:, 0, self.at, None]
        given = -matrix[:, self.at[:, None], self.others]
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
            Whatever it holds for nodes at rest is replaced [degC].
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
