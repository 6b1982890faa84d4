"""What is worth a full score, and how much chance would win: linear near the calibrated machine."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from gap_finder.candidates import next_larger
from gap_finder.hypotheses import AddedChange, AddedEffect, Listed
from gap_finder.keys import effect_of
from gap_finder.null_distribution import null_residuals
from gap_finder.score import Fit
from gap_finder.screen import NormalMatrices, ResidualSets, Screen
from plant_model.parameters import FloatArray

PER_KIND = 2
"""Candidates of a kind that the screening proposes for the full score. Set for time, as the next
two are."""

PROPOSED = 16
"""Candidates that the screening proposes in all."""

LENIENT = 0.5
"""Share of its prior's cost that a candidate must win back in the screening to be proposed [1]: the
screening is linear, the score is not."""

SETTLED = 1.6
"""What is left per run and channel at which nothing more is looked for beside a name [tolerances
squared]. Development split: machines with nothing missing leave 0.9 to 1.7."""

CHANCE = 0.99
"""Share of the data sets drawn with nothing missing in which less is won than is asked for [1]."""

Added = AddedEffect | AddedChange


def screened(best: Fit, listed: Listed, seed: int, law: float) -> tuple[list[list[Added]], float]:
    """Return what is to be fully scored, each at its starting points, and what chance would win.

    About the calibrated machine every answer is taken as linear in its size. That is exact enough
    for data sets in which nothing is missing, where all sizes are small; for the data itself it
    only proposes.
    """
    tried = listed.tried
    if not tried:
        return [], 0.0
    screen = Screen(NormalMatrices.of(best.designs, tried))
    residuals = [design.residual[None] for design in best.designs]
    data = ResidualSets.of(best.designs, tried, residuals, best.position())
    scores = screen.scores(data)
    prior = np.array([listed.costs[one.key] for one in tried])
    gain, before = scores.gain[0], float(scores.cost[0])
    unit = max(1.0, law, (before - float(gain.max())) / best.left.size)
    won = gain / unit - np.array(
        [one.scaled(float(s)).size_cost() for one, s in zip(tried, scores.scale[0], strict=True)]
    )
    chosen = _proposed(tried, won, prior, lenient=best.left_each > SETTLED)
    if not chosen:
        return [], 0.0
    drawn = null_residuals(screen, best.designs, best.observed, tried, before, seed)
    chance = screen.scores(ResidualSets.of(best.designs, tried, drawn))
    units = np.maximum(max(1.0, law), (chance.cost - chance.gain.max(axis=1)) / best.left.size)
    falls = (chance.gain / units[:, None] - prior).max(axis=1)
    proposed = [_starts(tried, tried[i], float(scores.scale[0, i])) for i in chosen]
    return proposed, float(np.quantile(falls, CHANCE))


def _proposed(
    tried: Sequence[Added], won: FloatArray, prior: FloatArray, *, lenient: bool
) -> list[int]:
    """Return the positions of the best few of every kind, the best first.

    Of laws that are far from linear the screening knows too little to leave them out: with
    *lenient* each is among them.
    """
    kinds: dict[str, list[str]] = {}
    found: list[int] = []
    for i in np.argsort(-(won - prior)).tolist():
        some = kinds.setdefault(tried[i].key.partition(":")[0], [])
        always = lenient and not some and is_far_from_linear(tried[i])
        if not always and (won[i] < LENIENT * prior[i] or len(found) >= PROPOSED):
            continue
        if tried[i].key not in some and len(some) < PER_KIND:
            some.append(tried[i].key)
            found.append(i)
    return found


def _starts(tried: Sequence[Added], one: Added, scale: float) -> list[Added]:
    """Return the sizes to start from: several for what is far from linear."""
    scaled = one.scaled(scale)
    if not isinstance(one, AddedEffect) or not is_far_from_linear(one):
        return [scaled]
    same = [other for other in tried if other.key == one.key and isinstance(other, AddedEffect)]
    larger = next_larger([other.candidate for other in same], one.candidate)
    return [scaled, *(AddedEffect(other) for other in larger)]


def is_far_from_linear(one: Added) -> bool:
    """Whether it depends on a temperature that it changes itself."""
    effect = effect_of(one.key)
    dependent = effect is not None and effect.temperature_dependent
    return dependent and isinstance(one, AddedEffect) and not one.candidate.is_switched
