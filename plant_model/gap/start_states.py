"""Parts that start wrongly: one that no sensor starts, or that is not at rest when a run begins.

The machine file says at which signal a part starts. Where a part is still warm from the run before,
or no sensor sits on it, that may be wrong, and a wrong start looks like any slow effect. Here every
part, and all that start at the same boundary temperature together, are tried at every other
thermometer. What each would change is known without simulating: it is the answer to a part's start,
which calibration has already.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from plant_model.gap.candidates import Candidate
from plant_model.gap.description import Described, key_of
from plant_model.gap.design import Surroundings
from plant_model.gap.judge import LEAST_SHARE, judge
from plant_model.gap.linearise import START_K, simulate_at
from plant_model.gap.nothing_missing import chance_share
from plant_model.gap.observations import Observations
from plant_model.gap.refit import Explained, explain
from plant_model.gap.screen import Data, Grams, Screen
from plant_model.machine import Machine
from plant_model.parameters import FloatArray
from plant_model.sensors import displacement_names

NAME = "start_state"
TITLE = "Part that starts at another temperature than the machine file says"

LEAST_K = 0.5
"""A start that is nowhere further from the file's than this is not tried [K]."""

SHARES = (0.5, 1.0)
"""Shares of the way from the first boundary temperature to the thermometer's reading, tried."""

LARGEST_SHARE = 1.5
"""A part may be further from the hall than the thermometer; no further than so many times [1]."""

REFITTED = 3
"""Starts that are calibrated in full."""


@dataclass(frozen=True)
class Start:
    """Another start of some parts.

    Attributes
    ----------
    place : tuple of str
        The parts.
    signal : str
        The thermometer or input that they start at ...
    share : float
        ... or on the way there from the first boundary temperature [1].
    """

    place: tuple[str, ...]
    signal: str
    share: float

    @property
    def key(self) -> str:
        """What it is called among what is tried."""
        return key_of(NAME, self.place)

    def put_into(self, machine: Machine) -> Machine:
        """Return the machine with these parts starting there."""
        nodes = tuple(
            replace(node, start=self.signal, start_share=self.share)
            if node.name in self.place
            else node
            for node in machine.nodes
        )
        return replace(machine, nodes=nodes)


def look_at_starts(
    now: Explained, around: Sequence[Surroundings], seed: int
) -> tuple[Described | None, Explained]:
    """Look for parts that start wrongly.

    Parameters
    ----------
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
    starts, tried = _candidates(now, around)
    if not tried:
        return None, now
    screen = Screen(Grams.of(now.designs, tried))
    residuals = [design.residual[None] for design in now.designs]
    scores = screen.scores(Data.of(now.designs, tried, residuals, now.pull()))
    gain = scores.unseen[0].sum(axis=0)
    if gain.max() < LEAST_SHARE * float(now.unseen.sum()):
        return None, now
    chance = chance_share(screen, now.designs, now.observed, tried, float(now.unseen.sum()), seed)
    usual = next(iter(now.machine.boundary_index))
    found: dict[str, tuple[Start, Explained]] = {}
    for i in np.argsort(-gain):
        start = starts[i]
        if start.key in found:
            continue
        if len(found) == REFITTED:
            break
        at_hall = all(n.start == usual for n in now.machine.nodes if n.name in start.place)
        scale = float(scores.scale[0, i]) if at_hall else 1.0
        start = replace(start, share=round(min(scale * start.share, LARGEST_SHARE), 3))
        one = explain(
            start.put_into(now.base),
            (start.key,),
            now.observed,
            [start.put_into(now.machine)],
            around,
        )
        found[start.key] = start, replace(one, acts=tried[i].acts)
    judged = judge(now, [one for _, one in found.values()], chance, len(now.observed[0].channels))
    if not judged.named:
        return None, now
    start, best = found[judged.one_of[0]]
    share = {"value": start.share, "low": start.share, "high": start.share, "unit": "1"}
    more = {"starts_at": start.signal, "parameters": {"share": share}}
    return Described(NAME, TITLE, start.place, judged, more), replace(best, added=now.added)


def _candidates(
    now: Explained, around: Sequence[Surroundings]
) -> tuple[list[Start], list[Candidate]]:
    machine, observed = now.machine, now.observed
    firsts = [_first_values(machine, one) for one in observed]
    signals = [name for name in firsts[0] if all(name in first for first in firsts)]
    begins = [simulate_at(machine, one).temperatures[0, 0] for one in observed]
    usual = next(iter(machine.boundary_index))
    starts, tried = [], []
    for place in _places(machine):
        at = [machine.node_index[name] for name in place]
        for signal in signals:
            for share in SHARES if signal != usual else SHARES[-1:]:
                away = [
                    first[usual] + share * (first[signal] - first[usual]) - begin[at]
                    for first, begin in zip(firsts, begins, strict=True)
                ]
                if max(float(np.abs(part).max()) for part in away) < LEAST_K:
                    continue
                start = Start(place, signal, share)
                answers = tuple(
                    _answer(known, len(machine.nodes), at, part)
                    for known, part in zip(around, away, strict=True)
                )
                starts.append(start)
                tried.append(Candidate(start.key, {}, answers))
    return starts, tried


def _answer(known: Surroundings, nodes: int, at: Sequence[int], away_k: FloatArray) -> FloatArray:
    """Return what starting some parts so far away changes in a run, weighted, shape (N,)."""
    by_start = known.own[:, known.own.shape[1] - nodes :]
    return np.asarray(by_start[:, at] @ away_k / START_K)


def _places(machine: Machine) -> list[tuple[str, ...]]:
    """Return every part, and those together that start at the same boundary temperature."""
    together = [
        tuple(node.name for node in machine.nodes if node.start == name)
        for name in machine.boundary_index
    ]
    return [(node.name,) for node in machine.nodes] + [p for p in together if len(p) > 1]


def _first_values(machine: Machine, observed: Observations) -> dict[str, float]:
    """Return the first value of every boundary temperature and thermometer of a run [degC]."""
    lengths = set(displacement_names(machine))
    found = {name: float(values[0]) for name, values in observed.drive.first.items()}
    for i, name in enumerate(observed.channels):
        known = observed.values[np.isfinite(observed.values[:, i]), i]
        if name not in lengths and len(known):
            found[name] = float(known[0])
    return {name: found[name] for name in sorted(found)}
