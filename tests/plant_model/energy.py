"""Where the heat of a simulation went: an account that does not use the integrator's own sums."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import pandas as pd

from plant_model.drive import drive_from
from plant_model.machine import Machine
from plant_model.network import Network, effects_in_force
from plant_model.parameters import FloatArray, Values
from plant_model.simulate import start_temperatures
from plant_model.trajectory import trajectories


@dataclass(frozen=True)
class EnergyBalance:
    """Energies over a whole simulation [J].

    Attributes
    ----------
    generated : float
        Heat from sources that depend on inputs only.
    dependent : float
        Heat, and exchange with the surroundings, of effects that depend on temperature.
    given_off : dict of str to float
        Heat given to each boundary temperature.
    stored : float
        Growth of the heat content of all nodes.
    """

    generated: float
    dependent: float
    given_off: dict[str, float]
    stored: float

    @property
    def closure(self) -> float:
        """What is missing in the account, relative to the heat turned over [1]."""
        gone = sum(self.given_off.values())
        missing = self.generated + self.dependent - gone - self.stored
        turned_over = abs(self.generated) + abs(self.dependent) + abs(gone) + abs(self.stored)
        return missing / max(turned_over, 1e-300)


def energy_balance(
    machine: Machine,
    inputs: pd.DataFrame,
    parameters: Mapping[str, float] | None = None,
    *,
    step_s: float = 1.0,
) -> EnergyBalance:
    """Account for the heat of a simulation.

    Temperatures are taken from the simulation; their course within a step is the cubic through
    both ends with the slopes that the heat flows there give.

    Parameters
    ----------
    machine, inputs, parameters, step_s
        As for :func:`~plant_model.simulate.simulate`; a step well below the fastest time constant
        (a jacket's: seconds) is needed for a close account.
    """
    values = Values(machine.parameters, parameters)
    network = Network(machine, values, effects_in_force(machine, values))
    drive = drive_from(machine, inputs, step_s)
    start = start_temperatures(machine, inputs, drive)[None, :]
    everything = trajectories(machine, network, [drive], [start])[0][0]
    temperatures, states = np.split(everything, [network.node_count], axis=1)
    steps = np.diff(drive.grid)
    heat = network.heat(drive.held)[0]
    names = list(machine.boundary_index)
    first, last = (
        np.stack([ends[name] for name in names], axis=-1) for ends in (drive.first, drive.last)
    )
    ends = [(temperatures[:-1], states[:-1], first), (temperatures[1:], states[1:], last)]
    flows = [_flows(network, drive.held, heat, *end) for end in ends]
    slopes = [flow.total / network.capacity[0] for flow in flows]
    half = (temperatures[1:] + temperatures[:-1]) / 2.0
    middle = half + steps[:, None] / 8.0 * (slopes[0] - slopes[1])
    mean_state = (states[1:] + states[:-1]) / 2.0
    flows.insert(1, _flows(network, drive.held, heat, middle, mean_state, (first + last) / 2.0))

    def integral(pieces: list[FloatArray]) -> float:
        """Return Simpson's rule over all steps."""
        mean = (pieces[0] + 4.0 * pieces[1] + pieces[2]) / 6.0
        return float(np.sum(mean * steps))

    given = {
        name: integral([flow.given_off[:, i] for flow in flows]) for i, name in enumerate(names)
    }
    return EnergyBalance(
        generated=float(np.sum(heat * steps[:, None])),
        dependent=integral([flow.dependent for flow in flows]),
        given_off=given,
        stored=float(np.sum(network.capacity[0] * (temperatures[-1] - temperatures[0]))),
    )


@dataclass(frozen=True)
class _Flows:
    """Heat flows at one instant of every step: (K, nodes), (K, boundaries), (K,) [W]."""

    total: FloatArray
    given_off: FloatArray
    dependent: FloatArray


def _flows(
    network: Network,
    held: dict[str, FloatArray],
    heat: FloatArray,
    temperatures: FloatArray,
    states: FloatArray,
    outside: FloatArray,
) -> _Flows:
    names = list(network.machine.boundary_index)
    columns = [held[name] for name in network.conductance_inputs]
    levels = np.stack(columns, axis=1) if columns else np.zeros((len(heat), 0))
    kinds, which = np.unique(levels, axis=0, return_inverse=True)
    total = heat.copy()
    given_off = np.zeros_like(outside)
    for i, level in enumerate(kinds):
        rows = np.flatnonzero(which.ravel() == i)
        inputs = {entry.name: np.zeros(1) for entry in network.machine.inputs}
        inputs |= {n: np.array([v]) for n, v in zip(network.conductance_inputs, level, strict=True)}
        matrix, boundary = (part[0] for part in network.conductances(inputs))
        total[rows] += outside[rows] @ boundary.T - temperatures[rows] @ matrix
        given_off[rows] = temperatures[rows] @ boundary - outside[rows] * boundary.sum(axis=0)
    inputs = held | {name: outside[:, i] for i, name in enumerate(names)}
    extra, _ = network.dependent(inputs, outside, temperatures[None], states[None])
    # Flows in series leave the last jacket with more than the first received: the part of the
    # diagonal that has no counterpart is heat that the flow carries out.
    carried = network.one_way_outflow(temperatures)
    return _Flows(total + extra[0], given_off, extra[0].sum(axis=1) - carried)
