"""Heat paths that the machine file forgot: between two parts, or from a part to the air.

Every pair of parts that no link joins is tried, and every part with every boundary temperature. A
loss in the motor that no catalogue holds looks a little like a path, so that a path must explain
much; one that calibration can imitate leaves nothing to name.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, replace
from itertools import combinations, product

import numpy as np

from plant_model.gap.candidates import Candidate
from plant_model.gap.description import Described, key_of
from plant_model.gap.design import Surroundings
from plant_model.gap.judge import judge
from plant_model.gap.linearise import modelled, simulate_at
from plant_model.gap.nothing_missing import chance_share
from plant_model.gap.observations import Observations
from plant_model.gap.refit import Explained, explain
from plant_model.gap.screen import Data, Grams, Screen
from plant_model.integrate import IntegrationError
from plant_model.machine import Item, Machine
from plant_model.parameters import FloatArray, Parameter

NAME = "heat_path"
TITLE = "Heat path that the machine file does not have"

SIZES_W_PER_K = (3.0, 30.0)
"""Conductances tried: one through a thin section or a still surface, one through a joint [W/K]."""

LARGEST_W_PER_K = 1000.0
"""No path is fitted to conduct more: two parts that close are one [W/K]."""

LEAST_SHARE = 0.5
"""Share of what is left on unseen runs that a path must explain [1]: some 260 are tried at two
sizes, and the best explained up to 32 % of windage and iron losses that no catalogue held."""

REFITTED = 10
"""Paths that are calibrated in full: near each other they look alike while they are small."""

TURN = 40
"""Paths simulated at once."""


@dataclass(frozen=True)
class Path:
    """A heat path between a part and another part or a boundary temperature."""

    place: tuple[str, str]
    boundary: bool

    @property
    def key(self) -> str:
        """What it is called among what is tried."""
        return key_of(NAME, self.place)

    @property
    def parameter(self) -> str:
        """Full name of its conductance."""
        return f"links.{'-'.join(self.place)}.{'coefficient' if self.boundary else 'conductance'}"

    def put_into(self, machine: Machine, value: float) -> Machine:
        """Return the machine with this path, its conductance free to be calibrated."""
        high = min(max(20.0, 10.0 * value), LARGEST_W_PER_K)
        source = "found by the gap finder"
        if self.boundary:
            one = Parameter(1.0, "m2", 1.0, 1.0, "together with the coefficient")
            film = Parameter(value, "W/(m2 K)", 0.0, high, source, calibrate=True)
            numbers, kind = {"area": one, "coefficient": film}, "convection"
        else:
            through = Parameter(value, "W/K", 0.0, high, source, calibrate=True)
            numbers, kind = {"conductance": through}, "conduction"
        item = Item("links", "-".join(self.place), kind, {"between": self.place}, numbers)
        links = [one for one in machine.items if one.family == "links"]
        rest = [one for one in machine.items if one.family != "links"]
        return replace(machine, items=(*links, item, *rest))


def look_at_paths(
    pool: Executor, now: Explained, around: Sequence[Surroundings], seed: int
) -> tuple[Described | None, Explained]:
    """Look for a heat path that the machine does not have.

    Parameters
    ----------
    pool : Executor
    now : Explained
        With no effect added.
    around : sequence of Surroundings
        About its machine.
    seed : int
        Of the draws in which nothing is missing.

    Returns
    -------
    described : Described or None
        What was named.
    after : Explained
        Calibrated anew with it, or *now*.
    """
    paths = list(_paths(now.machine))
    if not paths:
        return None, now
    jobs = [pool.submit(_answers, now.machine, one, paths) for one in now.observed]
    by_run = [job.result() for job in jobs]
    sized = list(product(range(len(SIZES_W_PER_K)), range(len(paths))))
    tried = [
        Candidate(paths[i].key, {}, tuple(answers[size][i] for answers in by_run))
        for size, i in sized
    ]
    screen = Screen(Grams.of(now.designs, tried))
    residuals = [design.residual[None] for design in now.designs]
    scores = screen.scores(Data.of(now.designs, tried, residuals, now.pull()))
    gain = scores.unseen[0].sum(axis=0)
    before = float(now.unseen.sum())
    if gain.max() < LEAST_SHARE * before:
        return None, now
    chance = chance_share(screen, now.designs, now.observed, tried, before, seed)
    best: dict[Path, int] = {}
    for k in np.argsort(-gain):
        best.setdefault(paths[sized[k][1]], int(k))
    chosen = dict(list(best.items())[:REFITTED])
    refits = []
    for path, k in chosen.items():
        value = float(scores.scale[0, k]) * SIZES_W_PER_K[sized[k][0]]
        refits.append(pool.submit(_explained, now, path, value, around, tried[k].acts))
    explained = {path.key: (path, job.result()) for path, job in zip(chosen, refits, strict=True)}
    most = max(LEAST_SHARE, chance)
    judged = judge(now, [one for _, one in explained.values()], most, len(now.observed[0].channels))
    if not judged.named:
        return None, now
    path, found = explained[judged.one_of[0]]
    described = Described(NAME, TITLE, path.place, judged, parameter=path.parameter)
    return described, replace(found, added=now.added)


def _paths(machine: Machine) -> Iterator[Path]:
    """Return the paths that the machine does not have."""
    joined = {frozenset(item.refs.get("between", ())) for item in machine.items}
    names = {item.name for item in machine.items}
    nodes = [node.name for node in machine.nodes]
    if "conduction" in machine.effects:
        pairs = [Path(pair, boundary=False) for pair in combinations(nodes, 2)]
        yield from (one for one in pairs if _is_new(one, joined, names))
    if "surface_convection" in machine.effects:
        pairs = [Path(pair, boundary=True) for pair in product(nodes, machine.boundary_index)]
        yield from (one for one in pairs if _is_new(one, joined, names))


def _is_new(path: Path, joined: set[frozenset[str]], names: set[str]) -> bool:
    return frozenset(path.place) not in joined and "-".join(path.place) not in names


def _answers(machine: Machine, observed: Observations, paths: Sequence[Path]) -> list[FloatArray]:
    """Return what every path of every size changes in a run, weighted, each (paths, N)."""
    base = modelled(simulate_at(machine, observed), observed)
    found = []
    for size in SIZES_W_PER_K:
        parts = []
        for start in range(0, len(paths), TURN):
            some = paths[start : start + TURN]
            grown = machine
            for path in some:
                grown = path.put_into(grown, size)
            sets = {path.parameter: size * np.eye(len(some))[i] for i, path in enumerate(some)}
            try:
                shown = modelled(simulate_at(grown, observed, sets), observed)
            except IntegrationError:
                shown = np.repeat(base, len(some), axis=0)
            change = (shown - base) * observed.weights
            parts.append(change.reshape(len(some), -1))
        found.append(np.concatenate(parts))
    return found


def _explained(
    now: Explained,
    path: Path,
    value: float,
    around: Sequence[Surroundings],
    acts: tuple[bool, ...],
) -> Explained:
    """Calibrate anew with a path."""
    base, start = path.put_into(now.base, value), path.put_into(now.machine, value)
    one = explain(base, (path.key,), now.observed, [start], around)
    return replace(one, acts=acts)
