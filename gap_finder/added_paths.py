"""The response to one more heat path, for thousands of paths at once, without their modes.

A path between parts i and j adds the flow g y from i to j, with y = T_i - T_j. The change in
temperatures D obeys C dD/dt = -L D - g d y with y = y0 + d.D, d = e_i - e_j, and y0 the difference
without the path. In the modes of the unchanged machine, the flow is a single unknown. With y linear
over a step the rest is exact, and a step costs as many operations as there are parts; computing the
modes of every changed machine would cost their cube. A path to a mass that nothing else touches
adds one more unknown, the temperature of the mass.

Temperature-dependent effects and their own states are linearised about the course without the path:
they add J D, with the same J for all paths. The responses are then valid for small changes only,
which is enough to propose candidates.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from gap_finder.in_run import machine_in_run, shown_per_kelvin
from gap_finder.observations import Observations
from plant_model.effects.stirred_film import share_of_motion
from plant_model.integrate import Modes
from plant_model.levels import conductances_at, levels_on
from plant_model.machine import Machine
from plant_model.nearby import Slopes, slopes_along
from plant_model.network import Network, effects_in_force
from plant_model.parameters import FloatArray, Values
from plant_model.simulate import at_rows, simulate

AT_ONCE = 512
"""Responses computed together; more only use more memory. Set on no data."""


@dataclass(frozen=True)
class AddedPath:
    """One more heat path.

    Attributes
    ----------
    between : tuple of str
        Two parts, a part and a boundary temperature, or only a part for a path to a separate mass;
        a part and several others if the heat is shared among them.
    sizes : tuple of float
        Conductances; of a driven path, at the top of the input's range [W/K].
    driver : str
        The input that the conductance grows with, as for a stirred film; empty if it is constant.
    masses : tuple of float
        Heat capacities, one for each size, of a mass that starts at the part's temperature [J/K];
        empty for a path that ends in the machine.
    shares : tuple of float
        Shares of the heat, one for each of several others [1], with sum 1. The path is driven by
        the difference from their mean with these weights.
    """

    between: tuple[str, ...]
    sizes: tuple[float, ...]
    driver: str = ""
    masses: tuple[float, ...] = ()
    shares: tuple[float, ...] = (1.0,)


def path_answers(
    machine: Machine,
    observed: Observations,
    paths: Sequence[AddedPath],
) -> list[FloatArray]:
    """Return the weighted response of a run to each path, (sizes, N).

    Parameters
    ----------
    machine : Machine
    observed : Observations
    paths : sequence of AddedPath
        All with the same number of sizes.
    """
    if not paths:
        return []
    stepped = _Stepped(machine, observed)
    answers: list[FloatArray] = []
    per_turn = max(1, AT_ONCE // len(paths[0].sizes))
    for start in range(0, len(paths), per_turn):
        answers += stepped.answers(paths[start : start + per_turn])
    return answers


class _Stepped:
    """One run of a machine on its grid, with the modes at every level of its inputs."""

    def __init__(self, machine: Machine, observed: Observations) -> None:
        self.observed = observed
        self.machine, own = machine_in_run(machine, observed)
        values = Values(self.machine.parameters, own, bounded=False)
        effects = effects_in_force(self.machine, values)
        network = Network(self.machine, values, effects)
        self.drive = drive = observed.drive
        base = simulate(
            self.machine,
            observed.run.frame,
            own,
            at=drive.grid,
            drive=drive,
            bounded=False,
        )
        self.base = base.temperatures[0]
        self.size = len(machine.nodes) + network.state_count
        self.steps = np.diff(drive.grid)
        levels = levels_on(self.machine, network, drive)
        self.keys = [tuple(row) for row in levels.tolist()]
        matrices = conductances_at(self.machine, network, list(dict.fromkeys(self.keys)))
        self.modes = {
            key: Modes.of(matrix, network.capacity, network.state_count).with_state_decay(
                network.state_decay()
            )
            for key, (matrix, _) in matrices.items()
        }
        self.slopes: Slopes | None = None
        if network.state_count or not network.linear:
            course = np.concatenate([self.base, base.states[0]], axis=1)
            self.slopes = slopes_along(network, drive, course)
        self.shown = shown_per_kelvin(self.machine, effects, network, observed.channels)[0]

    def answers(self, paths: Sequence[AddedPath]) -> list[FloatArray]:
        """Return the weighted response to each path, (sizes, N)."""
        index, count = self.machine.node_index, len(paths[0].sizes)
        ends = np.zeros((len(paths), self.size))
        first, last = np.zeros((2, len(paths), len(self.steps)))
        share = np.ones((len(paths), len(self.steps)))
        conductance = np.empty((len(paths), count))
        warming = np.zeros((len(paths), count))
        for row, path in enumerate(paths):
            start, *others = path.between
            ends[row, index[start]] = 1.0
            law = "conduction"
            if path.masses:
                first[row] = last[row] = self.base[0, index[start]]
                warming[row] = 1.0 / np.array(path.masses)
            elif others[0] in index:
                for name, part in zip(others, path.shares, strict=True):
                    ends[row, index[name]] = -part
            else:
                law = "surface_convection"
                first[row], last[row] = self.drive.first[others[0]], self.drive.last[others[0]]
            if path.driver:
                law = "stirred_film"
                share[row] = self._motion(path.driver)
            conductance[row] = np.array(path.sizes) * self._scale(law)
        apart = ends[:, : len(index)] @ self.base.T
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
        """Return how the paths change the channels, shape (paths, grid, C).

        *warming* is by how much a joule warms the mass behind [K/J], 0 if there is none.
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
            keep, steady, at_last = (weights[0] for weights in modes.weights(step))
            at_first = steady - at_last
            now = share[:, k] * (first[:, k] + np.einsum("sn,sn->s", seen, state) - behind)
            started, pushed = state, flow * at_last
            state = keep * state - flow * (at_first * now[:, None])
            if self.slopes is not None:
                read = self.slopes.seen(modes)
                state += started @ read @ self.slopes.at_start(k, modes) * at_first
                answer = self.slopes.at_end(k, modes, at_last)
                state, pushed = state + state @ read @ answer, pushed + pushed @ read @ answer
            behind = behind + 0.5 * step * rate * now
            slowed = np.einsum("sn,sn->s", seen, pushed) + 0.5 * step * rate
            then = share[:, k] * (last[:, k] + np.einsum("sn,sn->s", seen, state) - behind)
            then /= 1.0 + share[:, k] * slowed
            state -= pushed * then[:, None]
            behind += 0.5 * step * rate * then
            out[:, k + 1] = state @ shown
        return out
