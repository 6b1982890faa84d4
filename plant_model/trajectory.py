"""Stepping a machine's temperatures through runs, for many parameter sets at once."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from plant_model.drive import Drive
from plant_model.effects import Effect
from plant_model.integrate import TOLERANCE
from plant_model.level import Ends, LevelStepper
from plant_model.levels import Stretch, stretches_of
from plant_model.machine import Machine
from plant_model.nearby import changed, near_by
from plant_model.network import Network, state_slices
from plant_model.parameters import NUMBERS, FloatArray, Values
from plant_model.recent import Stepping, remember, remembered
from plant_model.rest import RestingParts
from plant_model.side_by_side import Track, side_by_side

FINE_S = 30.0
"""Longest step over which heat that is known ahead is taken as linear, and of a co-simulation with
a measured run [s]: a chiller switches every few minutes. Set on
no data."""

NOT_WARMING = ("structure.", NUMBERS)
"""Prefixes of parameters without effect on temperatures; a named number acts by its followers."""


def shared_trajectories(
    machine: Machine,
    values: Values,
    effects: Sequence[Effect],
    drives: Sequence[Drive],
    starts: Sequence[FloatArray],
    tolerance: float = TOLERANCE,
    *,
    near: bool = False,
) -> list[FloatArray]:
    """Return the same as :func:`trajectories`, stepping each temperature field only once.

    Sets that differ only in structure or readings have the same temperatures, and own states that
    do not affect temperatures follow afterwards.

    Parameters
    ----------
    machine : Machine
    values : Values
        The parameter sets.
    effects : sequence of Effect
        In force, as `effects_in_force` gives them.
    drives : sequence of Drive
        Of each run, with K + 1 instants.
    starts : sequence of array, shape (sets, nodes)
        Of each run [degC]; NaN for nodes that start at rest, which are found from the others.
    tolerance : float
        Local error allowed if a step is not exact [K].
    near : bool
        Step all sets to first order about the first one (:mod:`plant_model.nearby`).

    Returns
    -------
    list of array, shape (sets, K + 1, nodes + own states)
    """
    warming = [effect for effect in effects if effect.warms]
    others = [effect for effect in effects if not effect.warms]
    which, back = _distinct(values, others, starts)
    if len(which) < len(back):
        few = values.of_sets(which)
        warming = _of(few, warming)
    else:
        few = values
    stepped_effects = [effect for effect in warming if not effect.known_ahead]
    network = Network(machine, few, stepped_effects)
    begins = [start[which] for start in starts]
    if any(np.isnan(begin).any() for begin in begins):
        resting = RestingParts(machine, network)
        begins = [
            resting.filled(begin, drive.first_boundaries(machine))
            for begin, drive in zip(begins, drives, strict=True)
        ]
    ahead = [effect for effect in warming if effect.known_ahead]
    own_states: list[dict[str, FloatArray]] = [{} for _ in drives]
    parts, refined, more = [1] * len(drives), list(drives), None
    if ahead:
        clocks = Network(machine, few, ahead)
        parts = [math.ceil(float(np.diff(drive.grid).max()) / FINE_S - 1e-9) for drive in drives]
        refined = [drive.refined(part) for drive, part in zip(drives, parts, strict=True)]
        known = [_ahead(clocks, fine, begin) for fine, begin in zip(refined, begins, strict=True)]
        more = [heat for _, heat in known]
        own_states = [
            _by_effect(clocks, own[:, ::part]) for (own, _), part in zip(known, parts, strict=True)
        ]
    if near and len(which) > 1 and not network.settles:
        at = int(back[0])
        about = few.of_sets(back[:1])
        alone = Network(machine, about, _of(about, stepped_effects))
        begun = [begin[at : at + 1] for begin in begins]
        first = Stepping(machine, about, alone, drives, parts, begun, tolerance)
        courses = _near(network, first, at, refined, begins, more)
    else:
        courses = trajectories(machine, network, refined, begins, tolerance, more)
        remember(Stepping(machine, few, network, drives, parts, begins, tolerance), courses)
    stepped = [on_grid[:, ::part] for on_grid, part in zip(courses, parts, strict=True)]
    follow = any(effect.states for effect in others)
    following = Network(machine, values, others) if follow else None
    nodes, slices = network.node_count, state_slices(effects)
    results = []
    for drive, on_grid, states in zip(drives, stepped, own_states, strict=True):
        size = nodes + sum(len(effect.states) for effect in effects)
        out = np.empty((len(back), len(drive.grid), size))
        out[..., :nodes] = on_grid[back, :, :nodes]
        states |= _by_effect(network, on_grid[..., nodes:])
        states = {key: part[back] for key, part in states.items()}
        if following:
            states |= _by_effect(following, _followed(following, drive, out[..., :nodes]))
        for key, place in slices.items():
            out[..., nodes + place.start : nodes + place.stop] = states[key]
        results.append(out)
    return results


def _of(values: Values, effects: Sequence[Effect]) -> list[Effect]:
    """Return the same effects with other values."""
    return [type(effect)(effect.machine, values, effect.channel) for effect in effects]


def _near(
    network: Network,
    first: Stepping,
    about: int,
    drives: Sequence[Drive],
    starts: Sequence[FloatArray],
    more: Sequence[Ends] | None,
) -> list[FloatArray]:
    """Return the same as `trajectories`, to first order about one set, which *first* is alone."""
    only = slice(about, about + 1)
    along = stretches_of(first.machine, first.network, drives)
    bases = remembered(first)
    if bases is None:
        alone = [(begin[only], end[only]) for begin, end in more] if more is not None else None
        given = first.machine, first.network, drives, first.starts, first.tolerance
        bases = trajectories(*given, alone, along)
    heats = more if more is not None else [None] * len(drives)
    differs = changed(network, about, drives)
    runs = zip(drives, along, differs, bases, starts, heats, strict=True)
    return [near_by(network, first.network, about, *run) for run in runs]


def _by_effect(network: Network, states: FloatArray) -> dict[str, FloatArray]:
    """Return the own states, (sets, K + 1, own states), of each effect."""
    return {key: states[..., place] for key, place in network.state_slices().items()}


def _ahead(network: Network, drive: Drive, start: FloatArray) -> tuple[FloatArray, Ends]:
    """Return own states on the grid, and the heat at the start and the end of each step [W].

    All effects of the network are known ahead, so temperatures are not needed.
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
    values: Values, others: Sequence[Effect], starts: Sequence[FloatArray]
) -> tuple[npt.NDArray[np.intp], npt.NDArray[np.intp]]:
    """Return the positions of sets with distinct temperatures, and for each set which it uses."""
    quiet = (*NOT_WARMING, *(f"effects.{effect.key}." for effect in others))
    columns = [column for name, column in values.varying() if not name.startswith(quiet)]
    sets = len(starts[0])
    start = np.nan_to_num(np.concatenate(starts, axis=1))
    if np.any(start != start[:1]):
        columns.append(start)
    if not columns:
        return np.zeros(1, dtype=np.intp), np.zeros(sets, dtype=np.intp)
    rows = np.concatenate(columns, axis=1)
    which, back = np.unique(rows, axis=0, return_index=True, return_inverse=True)[1:]
    if len(which) == sets:
        which = back = np.arange(sets)
    return which, back.ravel()


def trajectories(
    machine: Machine,
    network: Network,
    drives: Sequence[Drive],
    starts: Sequence[FloatArray],
    tolerance: float = TOLERANCE,
    more: Sequence[Ends] | None = None,
    stretches: Sequence[Sequence[Stretch]] | None = None,
) -> list[FloatArray]:
    """Return temperatures and own states of each run, shape (sets, K + 1, nodes + states).

    *more* is further heat at the start and the end of each step, each (sets, K, nodes) [W];
    *stretches* are those of the runs, if already known.
    """
    of_runs = stretches or stretches_of(machine, network, drives)
    courses, tracks = [], []
    nodes = network.node_count
    for i, (drive, start, along) in enumerate(zip(drives, starts, of_runs, strict=True)):
        out = np.empty((len(start), len(drive.grid), nodes + network.state_count))
        out[:, 0, :nodes] = start
        out[:, 0, nodes:] = network.start_states(start, _at_begin(drive))
        heat = network.heat(drive.held)
        heats = (heat + more[i][0], heat + more[i][1]) if more is not None else (heat, heat)
        if network.linear:
            _go_exactly(out, drive, along, heats)
        else:
            tracks.append(_track(network, out[:, 0], drive, along, heats))
        courses.append(out)
    if tracks:
        for out, ends in zip(courses, side_by_side(network, tracks, tolerance), strict=True):
            out[:, 1:] = ends
    return courses


def _go_exactly(out: FloatArray, drive: Drive, stretches: Sequence[Stretch], heats: Ends) -> None:
    """Fill in a run, (sets, K + 1, size), after its first instant."""
    steps, outside = np.diff(drive.grid), _outside(stretches[0][0].network.machine, drive)
    for level, at in stretches:
        held = {name: values[at] for name, values in drive.held.items()}
        ends = _within(heats, at), (outside[0][at], outside[1][at])
        out[:, at.start + 1 : at.stop + 1] = level.exact(out[:, at.start], steps[at], held, *ends)


def _track(
    network: Network, start: FloatArray, drive: Drive, stretches: Sequence[Stretch], heats: Ends
) -> Track:
    """Return a run ready to be stepped side by side with others."""
    outside = _outside(network.machine, drive)
    first, last = (np.empty((len(start), len(drive.grid) - 1, start.shape[1])) for _ in range(2))
    levels: list[LevelStepper] = []
    for level, at in stretches:
        ends = _within(heats, at), (outside[0][at], outside[1][at])
        first[:, at], last[:, at] = level.forced(*ends)
        levels += [level] * (at.stop - at.start)
    return Track(start, np.diff(drive.grid), levels, drive.held, (first, last), outside)


def _within(heats: Ends, at: slice) -> Ends:
    """Return heat in some of the steps; if both ends are one array, they stay one."""
    first = heats[0][:, at]
    return first, first if heats[1] is heats[0] else heats[1][:, at]


def _outside(machine: Machine, drive: Drive) -> Ends:
    """Return boundary temperatures at the start and the end of each step, each (K, boundaries)."""
    first, last = (
        np.stack([ends[name] for name in machine.boundary_index], axis=-1)
        for ends in (drive.first, drive.last)
    )
    return first, last


def _at_begin(drive: Drive) -> dict[str, FloatArray]:
    """Return all inputs at the start, shape (1,) each."""
    return {name: values[:1] for name, values in (drive.held | drive.first).items()}


def _followed(network: Network, drive: Drive, temperatures: FloatArray) -> FloatArray:
    """Return own states that follow temperatures, (sets, K + 1, nodes), on the same grid."""
    at_start, at_end = (drive.held | ends for ends in (drive.first, drive.last))
    own = network.start_states(temperatures[:, 0], _at_begin(drive))
    ends = (at_start, temperatures[:, :-1]), (at_end, temperatures[:, 1:])
    return np.concatenate([own[:, None], network.followed(own, np.diff(drive.grid), *ends)], axis=1)
