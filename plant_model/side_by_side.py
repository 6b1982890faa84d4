"""Stepping runs side by side if something depends on temperature.

A step consists of short array operations, which cost hardly more for five runs than for one. The
hooks of effects take many instants at once: here each instant belongs to another run.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, cast

import numpy as np
import numpy.typing as npt
from numpy.lib.mixins import NDArrayOperatorsMixin

from plant_model.integrate import ExponentialRungeKutta, apply
from plant_model.level import Ends, Held, LevelStepper
from plant_model.network import Network
from plant_model.parameters import FloatArray


@dataclass
class Track:
    """One run, ready to be stepped.

    Attributes
    ----------
    start : array, shape (sets, size)
        Temperatures [degC] and own states.
    steps : array, shape (K,)
        Lengths of the steps [s].
    levels : list of LevelStepper
        In force in each step.
    held : dict of str to array, shape (K,)
        Inputs that are constant in each step.
    force : pair of array, shape (sets, K, size)
        Forcing in modes by inputs and boundaries at the start and the end of each step.
    outside : pair of array, shape (K, boundaries)
        Boundary temperatures then [degC].
    part : float
        Fraction of a step that error control steps at a time, which it adapts on the way [1].
    """

    start: FloatArray
    steps: FloatArray
    levels: list[LevelStepper]
    held: Held
    force: Ends
    outside: Ends
    part: float = 1.0


def side_by_side(network: Network, tracks: Sequence[Track], tolerance: float) -> list[FloatArray]:
    """Return [temperatures, own states] at the end of each step of each run, (sets, K, size).

    Parameters
    ----------
    network : Network
        Of all runs.
    tracks : sequence of Track
    tolerance : float
        Local error allowed [K].
    """
    # The longest first, so that the runs still going are always the first ones.
    longest = sorted(tracks, key=lambda track: -len(track.steps))
    lengths, held, outside = (
        _padded([track.steps for track in longest]),
        {name: _padded([track.held[name] for track in longest]) for name in longest[0].held},
        [_padded([track.outside[end] for track in longest]) for end in (0, 1)],
    )
    scheme = ExponentialRungeKutta(
        [track.levels[0].modes for track in longest], tolerance, network.error_scale
    )
    scheme.part = np.array([track.part for track in longest])
    now = np.stack([track.start for track in longest], axis=1)
    in_modes = apply(scheme.to_modes, now)
    ends = [np.empty((len(now), len(track.steps), now.shape[2])) for track in longest]
    forcing = _Forcing(network, scheme)
    going = len(longest)
    for k in range(len(lengths)):
        while len(longest[going - 1].steps) <= k:
            going -= 1
            longest[going].part = float(scheme.part[going])
            scheme.keep(going)
        now, in_modes = now[:, :going], in_modes[:, :going]
        for run, track in enumerate(longest[:going]):
            if k and track.levels[k] is not track.levels[k - 1]:
                scheme.enter(run, track.levels[k].modes)
                in_modes[:, run] = apply(scheme.to_modes[:, run], now[:, run])
        forcing.held = {name: values[k, :going] for name, values in held.items()}
        forcing.outside = outside[0][k, :going], outside[1][k, :going]
        first, last = (
            np.stack([track.force[end][:, k] for track in longest[:going]], axis=1)
            for end in (0, 1)
        )
        forcing.force = first, last
        in_modes = scheme.interval(in_modes, lengths[k, :going], forcing)
        now = apply(scheme.to_state, in_modes)
        if network.settles:
            _settle(network, forcing.held, now)
            in_modes = apply(scheme.to_modes, now)
        for run in range(going):
            ends[run][:, k] = now[:, run]
    for run, track in enumerate(longest[:going]):
        track.part = float(scheme.part[run])
    of_track = {id(track): end for track, end in zip(longest, ends, strict=True)}
    return [of_track[id(track)] for track in tracks]


def _padded(series: Sequence[FloatArray]) -> FloatArray:
    """Return series, each (K, ...), as one array (longest K, series, ...)."""
    out = np.zeros((len(series[0]), len(series), *series[0].shape[1:]))
    for i, values in enumerate(series):
        out[: len(values), i] = values
    return out


def _settle(network: Network, held: Held, now: FloatArray) -> None:
    """Let own states jump at the end of a step, in place."""
    nodes = network.node_count
    for run in range(now.shape[1]):
        inputs = {name: values[run : run + 1] for name, values in held.items()}
        now[:, run, nodes:] = network.settled(inputs, now[:, run, :nodes], now[:, run, nodes:])


class _Forcing:
    """Forcing of the modes of all runs within a step."""

    held: Held
    force: Ends
    outside: Ends

    def __init__(self, network: Network, scheme: ExponentialRungeKutta) -> None:
        self._network, self._scheme = network, scheme
        self._names = list(network.machine.boundary_index)
        self._decay = network.state_decay()[:, None]

    def __call__(self, at: FloatArray, in_modes: FloatArray) -> FloatArray:
        nodes = self._network.node_count
        to_nodes, own = self._scheme.to_state[..., :nodes, :nodes], in_modes[..., nodes:]
        gone = at[:, None]
        around = self.outside[0] + gone * (self.outside[1] - self.outside[0])
        inputs = self.held | {name: around[:, i] for i, name in enumerate(self._names)}
        temperatures = cast(FloatArray, _Temperatures(to_nodes, in_modes[..., :nodes]))
        heat, rates = self._network.dependent(inputs, around, temperatures, own)
        rate = self.force[0] + gone * (self.force[1] - self.force[0])
        rate[..., :nodes] += _in_modes(heat, to_nodes)
        rate[..., nodes:] += rates + self._decay * own
        return np.asarray(rate)


class _Temperatures(NDArrayOperatorsMixin):
    """Temperatures of nodes from modes, each computed when read: most effects read only a few.

    Parameters
    ----------
    to_nodes : array, shape (sets, runs, nodes, nodes)
    in_modes : array, shape (sets, runs, nodes)
    """

    def __init__(self, to_nodes: FloatArray, in_modes: FloatArray) -> None:
        self._to_nodes, self._in_modes = to_nodes, in_modes
        self.shape = in_modes.shape

    def __len__(self) -> int:
        return len(self._in_modes)

    def __getitem__(self, at: Any) -> FloatArray:
        if not (isinstance(at, tuple) and len(at) == 2 and at[0] is Ellipsis):
            return np.asarray(np.asarray(self)[at])
        rows = self._to_nodes[..., at[1], :]
        if rows.ndim == self._in_modes.ndim:
            return np.asarray(np.einsum("...m,...m->...", rows, self._in_modes))
        return apply(rows, self._in_modes)

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> FloatArray:
        return apply(self._to_nodes, self._in_modes)

    def __array_ufunc__(self, ufunc: np.ufunc, method: str, *given: Any, **options: Any) -> Any:
        arrays = [np.asarray(value) if value is self else value for value in given]
        return getattr(ufunc, method)(*arrays, **options)


class _Watched(_Temperatures):
    """Temperatures, each its own mode, that record which of them were read."""

    def __init__(self, values: FloatArray) -> None:
        super().__init__(np.eye(values.shape[-1])[None, None], values)
        self.read = np.zeros(values.shape[-1], dtype=bool)

    def __getitem__(self, at: Any) -> FloatArray:
        if isinstance(at, tuple) and len(at) == 2 and at[0] is Ellipsis:
            self.read[at[1]] = True
        return super().__getitem__(at)

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> FloatArray:
        self.read[:] = True
        return super().__array__(dtype, copy)


def nodes_read(network: Network, inputs: Held, course: FloatArray) -> npt.NDArray[np.intp]:
    """Return the nodes whose temperatures the temperature-dependent effects read.

    Parameters
    ----------
    network : Network
    inputs : dict of str to array, shape (1,)
    course : array, shape (1, 1, nodes + own states)
        Temperatures and own states at an instant.
    """
    nodes = network.node_count
    watched = _Watched(course[..., :nodes])
    outside = np.stack([inputs[name] for name in network.machine.boundary_index], axis=-1)
    network.dependent(inputs, outside, cast(FloatArray, watched), course[..., nodes:])
    return np.flatnonzero(watched.read)


def _in_modes(heat: FloatArray, to_nodes: FloatArray) -> FloatArray:
    """Return the forcing of the modes by heat [W]; they are orthogonal, so the matrix is the same.

    Parameters
    ----------
    heat : array, shape (sets, runs, nodes)
        Most effects heat few nodes.
    to_nodes : array, shape (sets or 1, runs, nodes, nodes)
    """
    heated = np.flatnonzero(heat.any(axis=(0, 1)))
    rows = to_nodes if len(heated) == heat.shape[-1] else to_nodes[..., heated, :]
    return apply(np.swapaxes(rows, -1, -2), heat[..., heated])
