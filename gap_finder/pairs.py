"""Two effects at once: where one alone explains little, or the wrong one explains most.

Effects are looked for one after another, and the first is chosen before the second is known. Where
too much is left after that, pairs are screened together, on the normal matrices: each of the best
effects in force, its size free, and every other beside it. Chance has many more pairs than effects
to choose from, and gets the same choice.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from gap_finder.candidates import LEAST, MOST, Candidate
from gap_finder.keys import law_of
from gap_finder.null_distribution import null_residuals
from gap_finder.refit import CandidateFit
from gap_finder.screen import NormalMatrices, ResidualSets, Screen
from gap_finder.selection import LATER_MOST, LATER_SHARE, LEAST_GAIN, cost_unit
from plant_model.parameters import FloatArray

FIRSTS = 12
"""Effects tried as one of a pair, those first that explain most alone; the other may be any."""

PROPOSED = 2
"""Pairs that are calibrated in full."""


@dataclass(frozen=True)
class ProposedPair:
    """Two effects that explain much together, as the screening has it.

    Attributes
    ----------
    first, second : int
        Positions among the candidates; the first explains more alone.
    cost : float
        Leave-one-run-out cost that they leave.
    null_q99 : float
        99 % quantile of the share that the best pair explains where nothing is missing [1].
    """

    first: int
    second: int
    cost: float
    null_q99: float


def screened_pairs(
    baseline: CandidateFit,
    tried: Sequence[Candidate],
    best: Mapping[str, int],
    found: Sequence[str],
    seed: int,
) -> list[ProposedPair]:
    """Return the pairs that may explain clearly more than what was found one after another.

    Parameters
    ----------
    baseline : CandidateFit
        With no effect added.
    tried : sequence of Candidate
    best : mapping of str to int
        Every effect's key, and its best candidate, those first that explain most alone.
    found : sequence of str
        Keys of what was found: none, one or two.
    seed : int
        Of the draws in which nothing is missing.

    Returns
    -------
    list of ProposedPair
        Best first, no more than `PROPOSED`.
    """
    places = list(best.values())
    some = [tried[i] for i in places]
    laws = np.array([law_of(one.key) for one in some])
    grams = NormalMatrices.of(baseline.designs, some, between=True)
    screen = Screen(grams)
    residuals = [design.residual[None] for design in baseline.designs]
    data = ResidualSets.of(baseline.designs, some, residuals, baseline.position())
    firsts = range(min(FIRSTS, len(some)))
    costs = _costs(grams, data, laws, firsts)[0]
    alone = screen.scores(data)
    single = alone.loro_cost[0].sum() - alone.loro_gain[0].sum(axis=0)
    before, nothing = float(baseline.loro_cost.sum()), float(alone.loro_cost[0].sum())
    left = _left_by(found, some, nothing, single, costs)
    unit = cost_unit(float(costs.min()), baseline.pieces)
    good = np.argwhere(_much_more(left, costs, before, unit))
    if not len(good):
        return []
    drawn = null_residuals(screen, baseline.designs, baseline.observed, some, before, seed)
    chance = ResidualSets.of(baseline.designs, some, drawn)
    by_chance = 1.0 - (
        _costs(grams, chance, laws, firsts).min(axis=(1, 2))
        / screen.scores(chance).loro_cost.sum(axis=1)
    )
    null_q99 = float(np.quantile(by_chance, 0.99))
    pairs: dict[frozenset[int], ProposedPair] = {}
    for i, j in sorted(good.tolist(), key=lambda pair: float(costs[tuple(pair)])):
        first, second = (i, j) if single[i] <= single[j] else (j, i)
        one = ProposedPair(places[first], places[second], float(costs[i, j]), null_q99)
        if 1.0 - one.cost / before >= null_q99:
            pairs.setdefault(frozenset((i, j)), one)
    return list(pairs.values())[:PROPOSED]


def both_needed(both: CandidateFit, alone: Sequence[CandidateFit], at_first: float) -> bool:
    """Tell whether two effects explain clearly more than either by itself.

    Parameters
    ----------
    both : CandidateFit
    alone : sequence of CandidateFit
        With one of them, each.
    at_first : float
        Leave-one-run-out cost before any effect was added.
    """
    cost = float(both.loro_cost.sum())
    unit = cost_unit(cost, both.pieces)
    left = np.array([float(one.loro_cost.sum()) for one in alone])
    return bool(np.all(_much_more(left, cost, at_first, unit)))


def _much_more(
    left: FloatArray | float, cost: FloatArray | float, at_first: float, unit: float
) -> FloatArray:
    """Tell where a cost is so much less than what is left that one more effect may be named."""
    gain = left - cost
    much = (gain > LATER_SHARE * at_first) | (gain > LATER_MOST * left)
    return np.asarray(much & (gain > LEAST_GAIN * unit))


def _left_by(
    found: Sequence[str],
    some: Sequence[Candidate],
    nothing: float,
    single: FloatArray,
    costs: FloatArray,
) -> float:
    """Return what the screening leaves with what was found, to compare like with like."""
    keys = [one.key for one in some]
    known = [keys.index(key) for key in found if key in keys]
    if len(known) < 2:
        return float(single[known[0]]) if known else nothing
    pairs = [(i, j) for i, j in (known[:2], known[1::-1]) if i < len(costs)]
    both = [float(costs[pair]) for pair in pairs if np.isfinite(costs[pair])]
    return min(both, default=float(single[known].min()))


def _costs(
    grams: NormalMatrices, data: ResidualSets, laws: FloatArray, firsts: Sequence[int]
) -> FloatArray:
    """Return the leave-one-run-out cost of pairs, shape (D, firsts, m); infinite where none is."""
    found = []
    for first in firsts:
        screen, seen = Screen(grams.beside(first)), data.beside(first)
        scores = screen.scores(seen)
        cost = scores.loro_cost.sum(axis=1)[:, None] - scores.loro_gain.sum(axis=1)
        size = MOST * screen.last_shared(seen)
        real = (size >= LEAST) & (size <= MOST) & (laws != laws[first])
        found.append(np.where(real, cost, np.inf))
    return np.stack(found, axis=1)
