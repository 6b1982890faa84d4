"""Selects the candidates for full scoring, by a linear screening about the calibrated machine."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from gap_finder.design import RunSensitivities, design_of
from gap_finder.hypotheses import Addition, Listed
from gap_finder.keys import bodies_of, effect_of
from gap_finder.leave_one_out import LeaveOneOut
from gap_finder.priors import Priors
from gap_finder.score import Fit, Units
from gap_finder.screen import Screen
from plant_model.effect_names import name_of
from plant_model.machine import Machine

LEADERS = 4
"""Candidates that are calibrated to the end, however little they gain at first; set for time, on no
data."""

PLACES_TRIED = 6
"""Places at which the best kind of change is scored, and rivals tried for each addition once
another has been added; set for time, on no data. Half of the places at most are cells of the same
bodies, because neighbours respond alike and would leave no room for any other place."""


@dataclass(frozen=True)
class Proposal:
    """A candidate to be scored fully.

    Attributes
    ----------
    addition : Addition
        At its estimated size.
    near : Machine
        The best without it, its numbers as the screening expects them with it.
    prior : float
        -2 log of its prior probability, without its size.
    """

    addition: Addition
    near: Machine
    prior: float

    @property
    def key(self) -> str:
        """The addition's."""
        return self.addition.key


def screened(
    nothing: Fit, best: Fit, sensitivities: Sequence[RunSensitivities], listed: Listed
) -> tuple[list[Proposal], list[Proposal]]:
    """Return the candidates to score fully, assuming responses linear in size.

    *sensitivities* are those of the best.

    Returns
    -------
    likely : list of Proposal
        The best of each kind: the likeliest, and others that lower the score in the screening.
    places : list of Proposal
        A few places of every kind of change and drivers of every law, to be scored if that kind
        does best.
    """
    tried = listed.tried
    if not tried:
        return [], []
    calibration = best.calibration
    designs = design_of(calibration.parts, sensitivities, calibration.units)
    channels = len(calibration.units)
    scores = Screen(LeaveOneOut(designs, best.position()), tried, channels).scores()
    prior = np.array([listed.costs[addition.key] for addition in tried])
    sized = [
        addition.scaled(scale) for addition, scale in zip(tried, scores.scale.tolist(), strict=True)
    ]
    # As in the score, a channel that nothing follows says little about any of them. Calibration
    # will also move each law's numbers, so the best may leave less than any of them does here.
    before, after = best.left.sum(axis=0), scores.left * calibration.units
    least = np.minimum(calibration.units, after.min(axis=0) / len(best.left))
    moved = best.numbers_moved - scores.numbers_gain.max()
    units = Units.of(least, moved, nothing)
    won = np.sum((before - after) / units.channels, axis=1)
    won += scores.numbers_gain / units.numbers + scores.others_gain
    won -= [addition.size_cost() for addition in sized]
    order = np.argsort(-(won - prior)).tolist()
    likely = _best_of_kinds(tried, order)
    # Near the calibrated machine, effects that calibration absorbed show little: always score one.
    likely = [i for i in likely if i == likely[0] or won[i] > prior[i]]
    keys = {tried[i].key for i in likely}
    places = [i for i in places_of(tried, order, listed.body) if tried[i].key not in keys]
    priors = Priors.of(best.base, calibrated=True)

    def proposal(i: int) -> Proposal:
        moved = {name: float(v[0]) for name, v in priors.values(scores.position[i][None]).items()}
        near = best.machine.with_values(moved, beyond=True)
        return Proposal(sized[i], near, listed.costs[sized[i].key])

    return [proposal(i) for i in likely], [proposal(i) for i in places]


def _best_of_kinds(tried: Sequence[Addition], order: Sequence[int]) -> list[int]:
    """Return the position of the first candidate of every kind."""
    first: dict[str, int] = {}
    for i in order:
        first.setdefault(name_of(tried[i].key), i)
    return list(first.values())


def places_of(
    tried: Sequence[Addition], order: Sequence[int], body: Mapping[str, str]
) -> list[int]:
    """Return the positions of the first few places or drivers of every kind."""
    keys: set[str] = set()
    of_kind: Counter[str] = Counter()
    of_bodies: Counter[tuple[str, ...]] = Counter()
    chosen = []
    for i in order:
        key = tried[i].key
        effect = effect_of(key)
        # The screening tells thermometers apart, and parts that switch a cooler.
        told_apart = effect is not None and (effect.on_channel or effect.switched)
        if told_apart or key in keys:
            continue
        where = bodies_of(key, body)
        kind = where[0]
        if of_kind[kind] < PLACES_TRIED and of_bodies[where] < PLACES_TRIED // 2:
            keys.add(key)
            of_kind[kind] += 1
            of_bodies[where] += 1
            chosen.append(i)
    return chosen
