"""Levels of the inputs that conductances use, along a run."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from plant_model.drive import Drive, levels_of
from plant_model.level import LevelStepper
from plant_model.machine import Machine
from plant_model.network import Network
from plant_model.parameters import FloatArray

Level = tuple[float, ...]
"""Values of the inputs that conductances use."""

Stretch = tuple[LevelStepper, slice]
"""Steps of a run at one level."""


def stretches_of(
    machine: Machine, network: Network, drives: Sequence[Drive]
) -> list[list[Stretch]]:
    """Return the stretches of each run in which the inputs of conductances stay at one level."""
    levels = [levels_on(machine, network, drive) for drive in drives]
    bounds = [_bounds(rows) for rows in levels]
    keys = [
        [tuple(rows[a].tolist()) for a in ends[:-1]]
        for rows, ends in zip(levels, bounds, strict=True)
    ]
    needed = list(dict.fromkeys(key for run in keys for key in run))
    matrices = conductances_at(machine, network, needed)
    steppers = {key: LevelStepper(network, *matrices[key]) for key in needed}
    return [
        [(steppers[key], slice(a, b)) for key, (a, b) in zip(run, pairwise(ends), strict=True)]
        for run, ends in zip(keys, bounds, strict=True)
    ]


def _bounds(levels: FloatArray) -> list[int]:
    """Return the steps at which levels begin, followed by the number of steps."""
    changes = np.flatnonzero(np.any(np.diff(levels, axis=0) != 0.0, axis=1)) + 1
    return [0, *changes.tolist(), len(levels)]


def conductances_at(
    machine: Machine, network: Network, keys: Sequence[Level]
) -> dict[Level, tuple[FloatArray, FloatArray]]:
    """Return the network's matrices at many levels of the inputs that conductances use.

    Parameters
    ----------
    machine : Machine
    network : Network
    keys : sequence of tuple of float
        Values of the network's ``conductance_inputs`` in their order; all other inputs are 0.

    Returns
    -------
    dict of key to (matrix, boundary)
        Shapes (sets or 1, nodes, nodes) and (sets or 1, nodes, boundaries) [W/K].
    """
    inputs = {entry.name: np.zeros(len(keys)) for entry in machine.inputs}
    columns = np.array(keys, dtype=np.float64).reshape(len(keys), -1).T
    inputs |= dict(zip(network.conductance_inputs, columns, strict=True))
    matrix, boundary = network.all_conductances(inputs, len(keys))
    return {key: (matrix[:, i], boundary[:, i]) for i, key in enumerate(keys)}


def levels_on(machine: Machine, network: Network, drive: Drive) -> FloatArray:
    """Return the inputs that conductances use over each step of the grid, shape (K, inputs).

    Parameters
    ----------
    machine : Machine
    network : Network
        Knows which inputs conductances use.
    drive : Drive
        With K + 1 instants.
    """
    spans = {entry.name: entry.high - entry.low for entry in machine.inputs}
    columns = [
        levels_of(drive.held[name], spans[name]) if name in drive.held else drive.first[name]
        for name in network.conductance_inputs
    ]
    steps = len(drive.grid) - 1
    return np.stack(columns, axis=1) if columns else np.zeros((steps, 0))
