"""Parameter sets near one another: the trajectory of one set, and the others to first order.

This is enough for derivatives, and finding the modes of every changed network would cost the cube
of its size. If T0 is the trajectory of the first set, the difference D of another set obeys

    dD/dt = C0^-1 (-L0 + J) D + g,    g = C^-1 F(T0) - C0^-1 F0(T0),

in the modes of the first network. F is all heat, and J is the Jacobian of the heat that depends on
temperature, along T0. g and J D are taken as linear over a step.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from plant_model.drive import Drive
from plant_model.exchange import Exchange
from plant_model.integrate import TOLERANCE, Modes, linear_steps
from plant_model.level import Ends, Held
from plant_model.levels import Stretch, levels_on
from plant_model.network import Network
from plant_model.parameters import FloatArray
from plant_model.side_by_side import nodes_read

Places = npt.NDArray[np.intp]


def near_by(
    network: Network,
    first: Network,
    about: int,
    drive: Drive,
    stretches: Sequence[Stretch],
    differs: Sequence[Changed],
    base: FloatArray,
    start: FloatArray,
    more: Ends | None,
) -> FloatArray:
    """Return temperatures and own states of a run, shape (sets, K + 1, nodes + own states).

    Parameters
    ----------
    network, first : Network
        Networks of all sets, and of the reference set.
    about : int
        Position of the reference set.
    drive : Drive
        With K + 1 instants.
    stretches : sequence of Stretch
        Of the reference set.
    differs : sequence of Changed
        Of all sets.
    base : array, shape (1, K + 1, nodes + own states)
        Trajectory of the reference set.
    start : array, shape (sets, nodes)
        Temperatures to start from [degC].
    more : pair of array, shape (sets, K, nodes), optional
        Further heat at the start and the end of each step [W].
    """
    nodes, course, steps = network.node_count, base[0], np.diff(drive.grid)
    begin, end = (drive.held | around for around in (drive.first, drive.last))
    heat = network.heat(drive.held)
    heats = (heat, heat) if more is None else (heat + more[0], heat + more[1])
    # A fast part warms most at the start of a step: the mean rate over the step matters.
    warming = np.diff(course[:, :nodes], axis=0) / steps[:, None]
    excess = (
        _excess(network, about, differs, warming, begin, course[:-1], heats[0]),
        _excess(network, about, differs, warming, end, course[1:], heats[1]),
    )
    own = network.start_states(start, {name: values[:1] for name, values in begin.items()})
    out = np.zeros((len(start), len(drive.grid), course.shape[1]))
    out[:, 0] = np.concatenate([start, own], axis=1) - course[0]
    if not first.linear:
        slopes = slopes_along(first, drive, course)
        for level, at in stretches:
            _answer(out, level.modes, at, steps, excess, slopes)
        out += course
        return out
    for level, at in stretches:
        modes = level.modes
        force = (part[:, at, :nodes] @ modes.to_modes[0].T for part in excess)
        before = out[:, at.start, :nodes] @ modes.to_modes[0].T
        after = linear_steps(modes, before, steps[at], *force)
        out[:, at.start + 1 : at.stop + 1, :nodes] = after @ modes.to_state[0].T
    out += course
    if network.state_count:
        warm = out[..., :nodes]
        ends = (begin, warm[:, :-1]), (end, warm[:, 1:])
        out[:, 1:, nodes:] = network.followed(out[:, 0, nodes:], steps, *ends)
    return out


@dataclass(frozen=True)
class Changed:
    """An exchange whose conductance differs in some sets.

    Attributes
    ----------
    exchange : Exchange
    sets : array of int
        Positions of these sets.
    change : array, shape (these sets, K)
        Difference from the reference set in each step [W/K].
    """

    exchange: Exchange
    sets: Places
    change: FloatArray


def changed(network: Network, about: int, drives: Sequence[Drive]) -> list[list[Changed]]:
    """Return the exchanges that differ from the reference set, for each run.

    Parameters
    ----------
    network : Network
        Of all sets.
    about : int
        Position of the reference set.
    drives : sequence of Drive
    """
    of_runs = [levels_on(network.machine, network, drive) for drive in drives]
    levels, which = np.unique(np.concatenate(of_runs), axis=0, return_inverse=True)
    of_run = np.split(which.ravel(), np.cumsum([len(rows) for rows in of_runs])[:-1])
    inputs = {entry.name: np.zeros(len(levels)) for entry in network.machine.inputs}
    inputs |= dict(zip(network.conductance_inputs, levels.T, strict=True))
    by_run: list[list[Changed]] = [[] for _ in drives]
    for entry in network.exchanges(inputs):
        if len(entry.conductance) == 1:
            continue
        change = entry.conductance - entry.conductance[about]
        sets = np.flatnonzero(change.any(axis=1))
        if len(sets):
            wide = np.broadcast_to(change[sets], (len(sets), len(levels)))
            for run, at in zip(by_run, of_run, strict=True):
                run.append(Changed(entry, sets, wide[:, at]))
    return by_run


def _excess(
    network: Network,
    about: int,
    differs: Sequence[Changed],
    warming: FloatArray,
    inputs: Held,
    course: FloatArray,
    heat: FloatArray,
) -> FloatArray:
    """Return the extra rates of each set along the reference course, (sets, K, nodes + own states).

    *inputs*, *course* and *heat* are at one end of each step; *warming* is over the step [K/s].
    """
    nodes = network.node_count
    warm = course[:, :nodes]
    outside = np.stack([inputs[name] for name in network.machine.boundary_index], axis=-1)
    rates = np.zeros((len(heat), *course.shape))
    flows = heat
    if not network.linear:
        alike = np.broadcast_to(course, rates.shape)
        dependent, own = network.dependent(inputs, outside, alike[..., :nodes], alike[..., nodes:])
        flows = heat + dependent
        rates[..., nodes:] = own - own[about]
    more = flows - flows[about]
    for item in differs:
        entry = item.exchange
        # Heat that a flow brings from another part is already in the temperature-dependent heat.
        apart = -warm[:, entry.node]
        if entry.boundary:
            apart += outside[:, entry.other]
        elif not entry.one_way:
            apart += warm[:, entry.other]
        flow = item.change * apart
        more[item.sets, :, entry.node] += flow
        if not (entry.boundary or entry.one_way):
            more[item.sets, :, entry.other] -= flow
    np.divide(more, network.capacity[:, None, :], out=rates[..., :nodes])
    if len(network.capacity) > 1:
        less = network.capacity[about] / network.capacity - 1.0
        for i in np.flatnonzero(less.any(axis=1)).tolist():
            rates[i, :, :nodes] += less[i] * warming
    return rates


@dataclass(frozen=True)
class Slopes:
    """Jacobian, along a course, of temperature-dependent heat and of the rates of own states.

    Attributes
    ----------
    read, answers : array of int
        Positions, among temperatures and own states, of what is read and of what responds.
    first, last : array, shape (K, answers, read)
        Derivatives at the start and at the end of each step [1/s].
    """

    read: Places
    answers: Places
    first: FloatArray
    last: FloatArray

    def seen(self, modes: Modes) -> FloatArray:
        """Return the matrix from modes of one parameter set to what is read, (size, read)."""
        return np.asarray(modes.to_state[0, self.read].T)

    def at_start(self, k: int, modes: Modes) -> FloatArray:
        """Return how modes respond to what is read at the start of a step, (read, size) [1/s]."""
        return np.asarray(self.first[k].T @ modes.to_modes[0][:, self.answers].T)

    def at_end(self, k: int, modes: Modes, at_last: FloatArray) -> FloatArray:
        """Return how far what is read at the end of a step moves the modes there, (read, size).

        What is read is computed without this response.

        Parameters
        ----------
        k : int
            The step.
        modes : Modes
        at_last : array, shape (size,)
            Effect of a mode's forcing at the end of the step on the mode there [s].
        """
        # The response acts on itself; the system to solve is small.
        push = at_last * modes.to_modes[0][:, self.answers].T
        itself = push @ self.seen(modes) @ self.last[k].T
        return np.asarray(
            self.last[k].T @ np.linalg.solve(np.eye(len(self.answers)) - itself, push)
        )


def slopes_along(network: Network, drive: Drive, course: FloatArray) -> Slopes:
    """Return the slopes of a network with one parameter set along a course.

    Parameters
    ----------
    network : Network
    drive : Drive
        With K + 1 instants.
    course : array, shape (K + 1, nodes + own states)
        Temperatures [degC] and own states.
    """
    nodes, names = network.node_count, list(network.machine.boundary_index)
    begin = {name: values[:1] for name, values in (drive.held | drive.first).items()}
    warm = nodes_read(network, begin, course[None, :1])
    read = np.append(warm, np.arange(nodes, course.shape[1]))
    step = TOLERANCE * network.error_scale[read]  # what stepping takes for equal
    slopes = []
    for at, around in ((course[:-1], drive.first), (course[1:], drive.last)):
        near = np.repeat(at[None], len(read) + 1, axis=0)
        near[np.arange(len(read)) + 1, :, read] += step[:, None]
        outside = np.stack([around[name] for name in names], axis=-1)
        heat, rates = network.dependent(
            drive.held | around, outside, near[..., :nodes], near[..., nodes:]
        )
        rates = rates + network.state_decay()[:, None, :] * near[..., nodes:]
        rate = np.concatenate([heat / network.capacity[:, None, :], rates], axis=2)
        slopes.append((rate[1:] - rate[0]) / step[:, None, None])
    answers = np.flatnonzero(np.any([part.any(axis=(0, 1)) for part in slopes], axis=0))
    first, last = (np.ascontiguousarray(np.moveaxis(part[..., answers], 0, 2)) for part in slopes)
    return Slopes(read, answers, first, last)


def _answer(
    out: FloatArray,
    modes: Modes,
    at: slice,
    steps: FloatArray,
    excess: Ends,
    slopes: Slopes,
) -> None:
    """Fill in the differences of all sets over a stretch, (sets, K + 1, size)."""
    to_modes, to_state = modes.to_modes[0], modes.to_state[0]
    seen = slopes.seen(modes)
    first, last = (np.swapaxes(part[:, at] @ to_modes.T, 0, 1) for part in excess)
    state = out[:, at.start] @ to_modes.T
    for k, start, end in zip(range(at.start, at.stop), first, last, strict=True):
        keep, whole, at_last = (part[0] for part in modes.weights(float(steps[k])))
        start = start + state @ seen @ slopes.at_start(k, modes)
        state = keep * state + (whole - at_last) * start + at_last * end
        state = state + state @ seen @ slopes.at_end(k, modes, at_last)
        out[:, k + 1] = state @ to_state.T
