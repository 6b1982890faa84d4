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

from plant_model.integrate import ExponentialRungeKutta, IntegrationError, apply
from plant_model.level import Ends, Held, LevelStepper
from plant_model.network import Network
from plant_model.parameters import FloatArray

Places = npt.NDArray[np.intp]


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
    begin = {name: values[0, :1] for name, values in held.items()}
    begin |= dict(zip(network.machine.boundary_index, outside[0][0, :1].T, strict=True))
    forcing = _Forcing(network, scheme, nodes_read(network, begin, now[:, :1]))
    going = len(longest)
    for k in range(len(lengths)):
        while len(longest[going - 1].steps) <= k:
            going -= 1
            longest[going].part = float(scheme.part[going])
            scheme.keep(going)
            forcing.keep(going)
        now, in_modes = now[:, :going], in_modes[:, :going]
        for run, track in enumerate(longest[:going]):
            if k and track.levels[k] is not track.levels[k - 1]:
                scheme.enter(run, track.levels[k].modes)
                forcing.enter(run)
                in_modes[:, run] = apply(scheme.to_modes[:, run], now[:, run])
        now_held = {name: values[k, :going] for name, values in held.items()}
        first, last = (
            np.stack([track.force[end][:, k] for track in longest[:going]], axis=1)
            for end in (0, 1)
        )
        forcing.step(now_held, (outside[0][k, :going], outside[1][k, :going]), (first, last))
        try:
            in_modes = scheme.interval(in_modes, lengths[k, :going], forcing)
        except IntegrationError:
            forcing.check_read(now)
            raise
        now = apply(scheme.to_state, in_modes)
        if network.settles:
            _settle(network, now_held, now)
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
    """Forcing of the modes of all runs within a step.

    Most effects read and heat few nodes, so only these nodes' temperatures and heat are converted
    from and to modes. Those that are read are known; those heated are noticed.
    """

    def __init__(self, network: Network, scheme: ExponentialRungeKutta, read: Places) -> None:
        self._network, self._scheme = network, scheme
        self._names = list(network.machine.boundary_index)
        self._decay = network.state_decay()[:, None]
        self._acting = np.zeros(network.node_count, dtype=bool)
        self._add(read)

    def _add(self, nodes: Places) -> None:
        """Convert temperatures and heat of further nodes."""
        self._acting[nodes] = True
        self._nodes = np.flatnonzero(self._acting)
        whole = self._scheme.to_state[..., : len(self._acting)]
        self._rows = np.ascontiguousarray(whole[..., self._nodes, :])

    def enter(self, run: int) -> None:
        """Follow the run at a position to its other modes."""
        self._rows[:, run] = self._scheme.to_state[:, run, self._nodes, : len(self._acting)]

    def keep(self, runs: int) -> None:
        """Continue with the first runs only, as many as given."""
        self._rows = self._rows[:, :runs]

    def step(self, held: Held, outside: Ends, force: Ends) -> None:
        """Go to the next step, given its held inputs and both ends of what varies in it."""
        self._held = held
        self._outside, self._warming = outside[0], outside[1] - outside[0]
        self._force, self._change = force[0], force[1] - force[0]

    def check_read(self, course: FloatArray) -> None:
        """Refuse effects that read nodes in this step that they did not read in the first one.

        Parameters
        ----------
        course : array, shape (sets, runs, nodes + own states)
            Temperatures [degC] and own states at the start of the step.

        Raises
        ------
        IntegrationError
            With the nodes' names.
        """
        inputs = self._held | dict(zip(self._names, self._outside.T, strict=True))
        read = nodes_read(self._network, inputs, course)
        if late := [self._network.machine.nodes[i].name for i in read if not self._acting[i]]:
            raise IntegrationError(
                f"an effect reads the temperature of {', '.join(late)}, which it did not read in"
                " the first step: its hooks must read the same nodes at every call"
            )

    def __call__(self, at: FloatArray, in_modes: FloatArray) -> FloatArray:
        nodes, gone = len(self._acting), at[:, None]
        around = self._outside + gone * self._warming
        inputs = self._held | dict(zip(self._names, around.T, strict=True))
        temperatures = np.full((*in_modes.shape[:-1], nodes), np.nan)
        temperatures[..., self._nodes] = apply(self._rows, in_modes[..., :nodes])
        own = in_modes[..., nodes:]
        heat, rates = self._network.dependent(inputs, around, temperatures, own)
        heated = heat.any(axis=(0, 1))
        if (heated > self._acting).any():
            self._add(np.flatnonzero(heated))
        rate = self._force + gone * self._change
        # Modes are orthogonal: heat goes back to them by the same matrix.
        rate[..., :nodes] += apply(np.swapaxes(self._rows, -1, -2), heat[..., self._nodes])
        rate[..., nodes:] += rates + self._decay * own
        return np.asarray(rate)


class _Watched(NDArrayOperatorsMixin):
    """Temperatures that record which of them were read."""

    def __init__(self, values: FloatArray) -> None:
        self._values, self.shape = values, values.shape
        self.read = np.zeros(values.shape[-1], dtype=bool)

    def __len__(self) -> int:
        return len(self._values)

    def __getitem__(self, at: Any) -> FloatArray:
        nodes = (
            at[1] if isinstance(at, tuple) and len(at) == 2 and at[0] is Ellipsis else slice(None)
        )
        self.read[nodes] = True
        return np.asarray(self._values[at])

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> FloatArray:
        self.read[:] = True
        return self._values

    def __array_ufunc__(self, ufunc: np.ufunc, method: str, *given: Any, **options: Any) -> Any:
        arrays = [np.asarray(value) if value is self else value for value in given]
        return getattr(ufunc, method)(*arrays, **options)


def nodes_read(network: Network, inputs: Held, course: FloatArray) -> Places:
    """Return the nodes whose temperatures the temperature-dependent effects read.

    Parameters
    ----------
    network : Network
    inputs : dict of str to array, shape (runs,)
    course : array, shape (sets, runs, nodes + own states)
        Temperatures and own states of each run at an instant.
    """
    nodes = network.node_count
    watched = _Watched(course[..., :nodes])
    outside = np.stack([inputs[name] for name in network.machine.boundary_index], axis=-1)
    network.dependent(inputs, outside, cast(FloatArray, watched), course[..., nodes:])
    return np.flatnonzero(watched.read)
