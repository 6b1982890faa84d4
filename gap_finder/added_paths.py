"""What one more heat path changes, for thousands of paths at once, without their modes.

A path between parts i and j adds the flow g y from i to j, with y = T_i - T_j. What it changes, D,
obeys C dD/dt = -L D - g d y with y = y0 + d.D, d = e_i - e_j, and y0 the difference without it: in
the modes of the machine as it stands a flow that is one unknown number. With y taken as linear over
a step the rest is exact, and a step costs as many operations as there are parts, where the modes of
every changed machine would cost their cube. A path to a mass that nothing else touches is the same
with one more number, the mass's own temperature.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from gap_finder.linearise import TOLERANCE
from gap_finder.observations import Observations
from plant_model.effects.stirred_film import share_of_motion
from plant_model.integrate import Modes, phi
from plant_model.machine import Machine
from plant_model.network import Network, effects_in_force
from plant_model.parameters import FloatArray, Values
from plant_model.sensors import readings
from plant_model.simulate import at_rows, simulate
from plant_model.structure import pose
from plant_model.trajectory import conductances_at, levels_on

AT_ONCE = 512
"""Paths that are stepped together; more only fill memory."""

ON_SURFACES = ("forced_convection", "natural_convection", "radiation")
"""Effects that act on every surface, a new one included."""


@dataclass(frozen=True)
class AddedPath:
    """One more heat path.

    Attributes
    ----------
    between : tuple of str
        Two parts, a part and a boundary temperature, or a part alone for a mass of its own.
    sizes : tuple of float
        Conductances, of a driven path at the top of the input's range [W/K].
    driver : str
        The input that it grows with, as a stirred film does; without one it is always there.
    masses : tuple of float
        Heat capacities, one for each size, of a mass that starts as warm as the part [J/K]; empty
        for a path that ends in the machine.
    """

    between: tuple[str, ...]
    sizes: tuple[float, ...]
    driver: str = ""
    masses: tuple[float, ...] = ()


def path_answers(
    machine: Machine,
    observed: Observations,
    paths: Sequence[AddedPath],
) -> list[FloatArray] | None:
    """Return what paths change in a run, weighted, each (sizes, N).

    Parameters
    ----------
    machine : Machine
    observed : Observations
    paths : sequence of AddedPath
        With as many sizes each.

    Returns
    -------
    list of array, or None
        None where something depends on temperature, follows late or acts on every surface: then
        there is no way around simulating each.
    """
    values = Values(machine.parameters)
    network = Network(machine, values, effects_in_force(machine, values))
    late = bool(network.state_count or observed.own or observed.absent)
    if late or not network.linear or machine.effects.keys() & set(ON_SURFACES):
        return None
    stepped = _Stepped(machine, network, observed)
    found: list[FloatArray] = []
    per_turn = max(1, AT_ONCE // len(paths[0].sizes)) if paths else 1
    for start in range(0, len(paths), per_turn):
        found += stepped.answers(paths[start : start + per_turn])
    return found


class _Stepped:
    """One run of a machine on its grid, and the modes of every level of its inputs."""

    def __init__(self, machine: Machine, network: Network, observed: Observations) -> None:
        self.machine, self.observed = machine, observed
        self.drive = drive = observed.drive
        frame = observed.run.frame
        base = simulate(machine, frame, tolerance=TOLERANCE, at=drive.grid, drive=drive)
        self.base = base.temperatures[0]
        self.steps = np.diff(drive.grid)
        levels = levels_on(machine, network, drive)
        self.keys = [tuple(row) for row in levels.tolist()]
        matrices = conductances_at(machine, network, list(dict.fromkeys(self.keys)))
        self.modes = {
            key: Modes.of(matrix, network.capacity) for key, (matrix, _) in matrices.items()
        }
        self.shown = _weights(machine, observed.channels)
        self._gains: dict[tuple[tuple[float, ...], float], tuple[FloatArray, ...]] = {}

    def _gain(self, key: tuple[float, ...], step: float) -> tuple[FloatArray, ...]:
        """Return what is kept over a step, and the gains of its first and last forcing."""
        known = (key, round(step, 9))
        if known not in self._gains:
            x = -self.modes[key].decay[0] * step
            last = step * phi(2, x)
            self._gains[known] = np.exp(x), step * phi(1, x) - last, last
        return self._gains[known]

    def answers(self, paths: Sequence[AddedPath]) -> list[FloatArray]:
        """Return what some paths change, each (sizes, N)."""
        index, count = self.machine.node_index, len(paths[0].sizes)
        ends = np.zeros((len(paths), len(index)))
        first, last = np.zeros((2, len(paths), len(self.steps)))
        share = np.ones((len(paths), len(self.steps)))
        conductance = np.empty((len(paths), count))
        warming = np.zeros((len(paths), count))
        for row, path in enumerate(paths):
            one, *other = path.between
            ends[row, index[one]] = 1.0
            law = "conduction"
            if path.masses:
                first[row] = last[row] = self.base[0, index[one]]
                warming[row] = 1.0 / np.array(path.masses)
            elif other[0] in index:
                ends[row, index[other[0]]] = -1.0
            else:
                law = "surface_convection"
                first[row], last[row] = self.drive.first[other[0]], self.drive.last[other[0]]
            if path.driver:
                law = "stirred_film"
                share[row] = self._motion(path.driver)
            conductance[row] = np.array(path.sizes) * self._scale(law)
        apart = ends @ self.base.T
        first, last = apart[:, :-1] - first, apart[:, 1:] - last
        repeated = (np.repeat(part, count, axis=0) for part in (ends, first, last, share))
        change = self._step(conductance.reshape(-1, 1), warming.ravel(), *repeated)
        rows = at_rows(self.drive.grid, change, self.observed.time_s) * self.observed.weights
        return list(rows.reshape(len(paths), count, -1))

    def _motion(self, driver: str) -> FloatArray:
        (most,) = (entry.most for entry in self.machine.inputs if entry.name == driver)
        return share_of_motion(self.drive.held[driver], most)

    def _scale(self, law: str) -> float:
        name = f"effects.{law}.scale"
        return self.machine.parameters[name].value if name in self.machine.parameters else 1.0

    def _step(
        self,
        conductance: FloatArray,
        warming: FloatArray,
        ends: FloatArray,
        first: FloatArray,
        last: FloatArray,
        share: FloatArray,
    ) -> FloatArray:
        """Return what channels show more than without the paths, shape (paths, grid, C).

        *warming* is what a joule warms the mass behind by [K/J], 0 where there is none.
        """
        out = np.zeros((len(ends), len(self.drive.grid), self.shown.shape[1]))
        state = np.zeros_like(ends)
        behind, rate = np.zeros(len(ends)), conductance[:, 0] * warming
        before: tuple[float, ...] | None = None
        for k, (key, step) in enumerate(zip(self.keys, self.steps.tolist(), strict=True)):
            modes = self.modes[key]
            if key != before:
                if before is not None:
                    state = state @ self.modes[before].to_state[0].T @ modes.to_modes[0].T
                seen = ends @ modes.to_state[0]
                flow = conductance * seen
                shown = modes.to_state[0].T @ self.shown
                before = key
            keep, at_first, at_last = self._gain(key, step)
            now = share[:, k] * (first[:, k] + np.einsum("sn,sn->s", seen, state) - behind)
            state = keep * state - flow * (at_first * now[:, None])
            behind = behind + 0.5 * step * rate * now
            slowed = np.einsum("sn,sn->s", seen * flow, np.broadcast_to(at_last, flow.shape))
            slowed += 0.5 * step * rate
            then = share[:, k] * (last[:, k] + np.einsum("sn,sn->s", seen, state) - behind)
            then /= 1.0 + share[:, k] * slowed
            state -= flow * (at_last * then[:, None])
            behind += 0.5 * step * rate * then
            out[:, k + 1] = state @ shown
        return out


def _weights(machine: Machine, channels: Sequence[str]) -> FloatArray:
    """Return what each channel shows per kelvin of each part, shape (nodes, C)."""
    values = Values(machine.parameters)
    effects = effects_in_force(machine, values)
    slices = Network(machine, values, effects).state_slices()
    count = len(machine.nodes)
    inputs = {entry.name: np.zeros(count + 1) for entry in machine.inputs}
    rise = np.concatenate([np.zeros((1, count)), np.eye(count)])[None]
    none = np.zeros((1, count + 1, 0))
    moved = pose(effects, slices, inputs, rise, none)
    seen = readings(machine, effects, slices, inputs, np.zeros(count + 1), rise, none, moved)
    shown = np.stack([seen[name][0] for name in channels], axis=-1)
    return np.asarray(shown[1:] - shown[0])
