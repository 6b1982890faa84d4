"""Stepping a machine's temperatures along a run, for many parameter sets at once."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise

import numpy as np
import numpy.typing as npt

from plant_model.drive import Drive, levels_of
from plant_model.effects import Effect
from plant_model.integrate import TOLERANCE
from plant_model.level import Ends, LevelStepper
from plant_model.machine import Machine
from plant_model.network import Network, state_slices
from plant_model.parameters import NUMBERS, FloatArray, Values
from plant_model.rest import RestingParts

MATRIX_NUMBERS = 4_000_000
"""Conductances kept at once; those of more levels of the inputs are computed in turns."""

Level = tuple[float, ...]
"""Values of the inputs that conductances use."""

FINE_S = 30.0
"""Longest step over which heat that is known ahead runs along a line [s]: a chiller switches every
few minutes."""

NOT_WARMING = ("structure.", NUMBERS)
"""How parameters begin that no temperature depends on; a page's number acts by what is tied to it.
"""


def shared_trajectory(
    machine: Machine,
    values: Values,
    effects: Sequence[Effect],
    drive: Drive,
    start: FloatArray,
    tolerance: float = TOLERANCE,
) -> FloatArray:
    """Return what :func:`trajectory` does, stepping each temperature field once.

    Sets that differ in what moves or reads alone have the same temperatures, and own states that
    nothing warms by follow afterwards.

    Parameters
    ----------
    machine : Machine
    values : Values
        The parameter sets.
    effects : sequence of Effect
        In force, as `effects_in_force` gives them.
    drive : Drive
        With K + 1 instants.
    start : array, shape (sets, nodes)
        [degC]; NaN for nodes that start at rest, which is found from the others.
    tolerance : float
        Local error where a step is not exact [K].

    Returns
    -------
    array, shape (sets, K + 1, nodes + own states)
    """
    warming = [effect for effect in effects if effect.warms]
    others = [effect for effect in effects if not effect.warms]
    which, back = _distinct(values, others, start)
    if len(which) < len(start):
        few = values.of_sets(which)
        warming = [type(one)(machine, few, one.channel) for one in warming]
    else:
        few = values
    network = Network(machine, few, [one for one in warming if not one.known_ahead])
    begin = start[which]
    if np.isnan(begin).any():
        begin = RestingParts(machine, network).filled(begin, drive.first_boundaries(machine))
    states = {}
    ahead = [one for one in warming if one.known_ahead]
    if ahead:
        parts = math.ceil(float(np.diff(drive.grid).max()) / FINE_S - 1e-9)
        fine = drive.refined(parts)
        clocks = Network(machine, few, ahead)
        own, heat = _ahead(clocks, fine, begin)
        stepped = trajectory(machine, network, fine, begin, tolerance, heat)[:, ::parts]
        states = _by_effect(clocks, own[:, ::parts])
    else:
        stepped = trajectory(machine, network, drive, begin, tolerance)
    nodes, slices = network.node_count, state_slices(effects)
    out = np.empty((len(start), len(drive.grid), nodes + sum(len(one.states) for one in effects)))
    out[..., :nodes] = stepped[back, :, :nodes]
    states |= _by_effect(network, stepped[..., nodes:])
    states = {key: part[back] for key, part in states.items()}
    if any(one.states for one in others):
        following = Network(machine, values, others)
        states |= _by_effect(following, _followed(following, drive, out[..., :nodes]))
    for key, place in slices.items():
        out[..., nodes + place.start : nodes + place.stop] = states[key]
    return out


def _by_effect(network: Network, states: FloatArray) -> dict[str, FloatArray]:
    """Return the own states, (sets, K + 1, own states), of each effect."""
    return {key: states[..., place] for key, place in network.state_slices().items()}


def _ahead(network: Network, drive: Drive, start: FloatArray) -> tuple[FloatArray, Ends]:
    """Return own states on the grid, and the heat at the start and the end of each step [W].

    All effects of the network are known ahead, so that no temperature is there to be asked for.
    """
    steps = np.diff(drive.grid)
    shape = (len(start), len(steps))
    unknown = np.full((*shape, network.node_count), np.nan)
    outside = np.full((len(steps), network.boundary_count), np.nan)
    own = np.zeros((len(start), len(drive.grid), network.state_count))
    own[:, 0] = network.start_states(start, _at_begin(drive))
    rates = network.dependent(drive.held, outside, unknown, own[:, 1:])[1]
    own[:, 1:] = own[:, :1] + np.cumsum(rates * steps[:, None], axis=1)
    first, last = (
        network.dependent(drive.held, outside, unknown, states)[0]
        for states in (own[:, :-1], own[:, 1:])
    )
    return own, (first, last)


def _distinct(
    values: Values, others: Sequence[Effect], start: FloatArray
) -> tuple[npt.NDArray[np.intp], npt.NDArray[np.intp]]:
    """Return the positions of sets of different temperatures, and which of these each set has."""
    quiet = (*NOT_WARMING, *(f"effects.{effect.key}." for effect in others))
    columns = [column for name, column in values.varying() if not name.startswith(quiet)]
    known = np.nan_to_num(start)
    if np.any(known != known[:1]):
        columns.append(known)
    if not columns:
        return np.zeros(1, dtype=np.intp), np.zeros(len(start), dtype=np.intp)
    rows = np.concatenate(columns, axis=1)
    which, back = np.unique(rows, axis=0, return_index=True, return_inverse=True)[1:]
    if len(which) == len(start):
        which = back = np.arange(len(start))
    return which, back.ravel()


def trajectory(
    machine: Machine,
    network: Network,
    drive: Drive,
    start: FloatArray,
    tolerance: float = TOLERANCE,
    more: Ends | None = None,
) -> FloatArray:
    """Return temperatures and own states on the grid, shape (sets, K + 1, nodes + states).

    *more* is further heat at the start and the end of each step, each (sets, K, nodes) [W].
    """
    levels = levels_on(machine, network, drive)
    heat = network.heat(drive.held)
    ends = [heat + further for further in more] if more is not None else [heat, heat]
    names = list(machine.boundary_index)
    outside = [np.stack([u[name] for name in names], axis=-1) for u in (drive.first, drive.last)]
    nodes = network.node_count
    out = np.empty((len(start), len(drive.grid), nodes + network.state_count))
    out[:, 0, :nodes] = start
    out[:, 0, nodes:] = network.start_states(start, _at_begin(drive))
    steps = np.diff(drive.grid)
    changes = np.flatnonzero(np.any(np.diff(levels, axis=0) != 0.0, axis=1)) + 1
    bounds = [0, *changes.tolist(), len(steps)]
    keys = list(dict.fromkeys(tuple(levels[a].tolist()) for a in bounds[:-1]))
    at_once = max(1, MATRIX_NUMBERS // (network.sets * nodes**2))
    ahead: dict[Level, tuple[FloatArray, FloatArray]] = {}
    known: dict[Level, LevelStepper] = {}
    for a, b in pairwise(bounds):
        key = tuple(levels[a].tolist())
        if key not in known:
            if key not in ahead:
                ahead = conductances_at(machine, network, keys[len(known) :][:at_once])
            known[key] = LevelStepper(network, *ahead[key], tolerance)
        held = {name: values[a:b] for name, values in drive.held.items()}
        heats, degc = (ends[0][:, a:b], ends[1][:, a:b]), (outside[0][a:b], outside[1][a:b])
        out[:, a + 1 : b + 1] = known[key].through(out[:, a], steps[a:b], held, heats, degc)
    return out


def _at_begin(drive: Drive) -> dict[str, FloatArray]:
    """Return all inputs at the start, shape (1,) each."""
    return {name: values[:1] for name, values in (drive.held | drive.first).items()}


def _followed(network: Network, drive: Drive, temperatures: FloatArray) -> FloatArray:
    """Return own states that follow temperatures, (sets, K + 1, nodes), on the same grid."""
    at_start, at_end = (drive.held | ends for ends in (drive.first, drive.last))
    own = network.start_states(temperatures[:, 0], _at_begin(drive))
    ends = (at_start, temperatures[:, :-1]), (at_end, temperatures[:, 1:])
    return np.concatenate([own[:, None], network.followed(own, np.diff(drive.grid), *ends)], axis=1)


def conductances_at(
    machine: Machine, network: Network, keys: Sequence[Level]
) -> dict[Level, tuple[FloatArray, FloatArray]]:
    """Return the network's matrices at many levels of the inputs that conductances use.

    Parameters
    ----------
    machine : Machine
    network : Network
    keys : sequence of tuple of float
        Values of the network's ``conductance_inputs``, in their order; all other inputs are 0.

    Returns
    -------
    dict of key to (matrix, boundary)
        Shapes (sets, nodes, nodes) and, from each boundary temperature, (sets, nodes, boundaries)
        [W/K].
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
        Says which inputs conductances use.
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
