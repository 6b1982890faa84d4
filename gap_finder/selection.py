"""Selection of effects by leave-one-run-out cost, posterior odds and the null distribution."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from gap_finder.refit import CandidateFit
from plant_model.effects import catalogue
from plant_model.parameters import FloatArray

LEAST_SHARE = 0.15
"""Share of the leave-one-run-out cost that an effect must explain to be named [1]."""

ABOVE_TOLERANCE = 2.2
"""Cost per run and channel from which something is wrong even if no effect explains it: half as
much again as the tolerance, all the time."""

MOSTLY = 0.5
"""Where more than the tolerance is left after all that was added, and less than this share was
explained, what was named does little of what is missing [1]: something else is."""

LEAST_GAIN = 10.0
"""Fall of the cost that an effect must bring, of the leave-one-run-out cost and of what calibration
on all runs leaves, each in units of `cost_unit` [1]: what makes runs easier to predict and explains
none of them only takes the place of other unknowns."""

LATER_SHARE, LATER_MOST = 0.1, 0.5
"""Share of what was left at first that a further effect must explain, or of what is left now [1].

What is left of a strong effect is its law being not quite the machine's, and looks like others."""

MOST_RUNS = 0.75
"""Share of the runs in which an effect acts that it must make better to be named [1]."""

LARGER_SHARE = 0.6
"""Share that an effect must explain to be named larger than usual [1]: a law that is only like what
is missing may well fit better where no bound holds it."""

NEARLY_ALL = 0.9
"""Share from which an effect is named though what makes its law ends at an end of its range [1]:
where it is that strong, a law that is not quite the machine's shows."""

FAR_BETTER = 0.5
"""Share of the best one's cost on all runs together at which another one cannot be excluded, both
being larger than usual [1]: how such predict runs from the others is known from derivatives at one
point, which is not much where the answer is far from linear."""

MOST_SENSORS = 2
"""A sensor's error shows on that sensor: one that may as well be on any of more is something else's
doing."""

RIVAL_ODDS = 0.05
"""An effect with this share of the best one's probability or more cannot be excluded."""


@dataclass(frozen=True)
class SelectionRound:
    """One round of selection: which one more effect is missing, if any.

    Attributes
    ----------
    baseline : CandidateFit
        The fit that the round began with.
    fits : tuple of CandidateFit
        Each with one more effect, least leave-one-run-out cost first.
    probability : tuple of float
        Posterior probability of each among these.
    explained_share : float
        What the one named, or else the best one, explains of the leave-one-run-out cost [1].
    null_q99 : float
        99 % quantile of what the best of all candidates explains where nothing is missing [1].
    one_of : tuple of str
        Names that the data cannot tell apart, the best first; empty if none is named.
    above_tolerance : bool
        Whether what was left before is more than the tolerance.
    """

    baseline: CandidateFit
    fits: tuple[CandidateFit, ...]
    probability: tuple[float, ...]
    explained_share: float
    null_q99: float
    one_of: tuple[str, ...]
    above_tolerance: bool

    @property
    def named(self) -> bool:
        """Whether an effect is named."""
        return bool(self.one_of)

    @property
    def best(self) -> CandidateFit:
        """The fit that is named, or else the best one."""
        key = self.one_of[:1]
        return next((one for one in self.fits if one.added[-1:] == key), self.fits[0])


def cost_per_run_and_channel(baseline: CandidateFit) -> float:
    """Return the leave-one-run-out cost per run and channel [tolerances squared]."""
    return float(baseline.loro_cost.sum()) / baseline.pieces


def above_tolerance(fit: CandidateFit) -> bool:
    """Tell whether so much is left that something is wrong even if no effect explains it."""
    return cost_per_run_and_channel(fit) > ABOVE_TOLERANCE


def adequate(before: CandidateFit, after: CandidateFit) -> bool:
    """Tell whether what was added explains most of what was missing, or leaves little."""
    explained = 1.0 - float(after.loro_cost.sum()) / float(before.loro_cost.sum())
    return explained >= MOSTLY or not above_tolerance(after)


def cost_unit(least: float, pieces: int) -> float:
    """Return the unit in which `select_effect` compares costs, from *pieces* of evidence."""
    return max(1.0, least / pieces)


def odds_against_best(costs: FloatArray, unit: float) -> FloatArray:
    """Return the odds of candidate fits against the best of them, from their costs, shape (M,)."""
    return np.asarray(np.exp(-(costs - costs.min()) / (2.0 * unit)))


def odds_among(fits: Mapping[str, CandidateFit]) -> dict[str, float]:
    """Return the odds of explanations of the same runs against the best of them, the best first.

    Parameters
    ----------
    fits : mapping of str to CandidateFit
        By any names, one or more.
    """
    left = {name: float(one.loro_cost.sum()) for name, one in fits.items()}
    ranked = sorted(left, key=lambda name: left[name])
    costs = np.array([left[name] for name in ranked])
    odds = odds_against_best(costs, cost_unit(float(costs[0]), fits[ranked[0]].pieces))
    return dict(zip(ranked, odds.tolist(), strict=True))


def clearly_better(one: CandidateFit, other: CandidateFit, odds: float) -> bool:
    """Tell whether one explanation of the same runs leaves so much less than another.

    Parameters
    ----------
    one, other : CandidateFit
    odds : float
        The odds against the other must be less than this [1].
    """
    return odds_among({"one": one, "other": other})["other"] < odds


def out_of_range(one: CandidateFit, share: float) -> bool:
    """Tell whether a fit ends at its bounds and, by its *share*, only resembles what is missing."""
    effect = catalogue().get(one.added[-1].partition(":")[0])
    if effect is None or effect.amplitude in one.at_bounds:
        return bool(one.at_bounds)
    return bool(one.at_bounds) and share < NEARLY_ALL


def _helps(best: CandidateFit, baseline: CandidateFit) -> bool:
    """Tell whether a fit makes most of those runs better in which its effect acts."""
    better = best.loro_cost < baseline.loro_cost
    return bool(np.mean(better[list(best.acts)] if any(best.acts) else better) >= MOST_RUNS)


def _explains(best: CandidateFit, baseline: CandidateFit) -> bool:
    """Tell whether a fit leaves clearly less of all runs together, too.

    It may show before the runs' own unknowns are calibrated, which can do some of its work, or
    after.
    """
    pairs = (
        (baseline.cost, best.cost),
        (baseline.calibration.cost, best.calibration.cost),
    )
    return any(
        before - after > LEAST_GAIN * cost_unit(after, best.pieces) for before, after in pairs
    )


def _fits_far_better(one: CandidateFit, best: CandidateFit) -> bool:
    """Tell whether one effect larger than usual fits all runs far better than the best one."""
    if one is best or not (one.beyond_usual and best.beyond_usual):
        return False
    return one.calibration.cost < FAR_BETTER * best.calibration.cost


def _of_any_sensor(keys: Sequence[str]) -> bool:
    """Tell whether an error of one sensor may as well be on any of several others."""
    names = (key.partition(":")[0] for key in keys if ":" in key)
    # A change of the description has its place behind the colon, and no sensor.
    sensors = Counter(n for n in names if n in catalogue() and catalogue()[n].on_channel)
    return any(count > MOST_SENSORS for count in sensors.values())


def select_effect(
    baseline: CandidateFit,
    fits: Sequence[CandidateFit],
    null_q99: float,
    channels: int,
    at_first: float = 0.0,
) -> SelectionRound:
    """Select by leave-one-run-out cost: how well each fit predicts runs from the others.

    Parameters
    ----------
    baseline : CandidateFit
    fits : sequence of CandidateFit
        Each with one more effect.
    null_q99 : float
        99 % quantile of what the best of all candidates explains where nothing is missing [1].
    channels : int
    at_first : float
        Leave-one-run-out cost before any effect was added: where a strong effect has been named,
        what its law leaves is not to be given a name of its own.

    Notes
    -----
    A run's channel is the unit of evidence. Costs are compared in units of what the best fit leaves
    per run and channel, and never in less than one: a model that is wrong by more than its
    tolerance cannot be sure of small differences.
    """
    ranked = sorted(fits, key=lambda one: float(one.loro_cost.sum()))
    costs = np.array([float(one.loro_cost.sum()) for one in ranked])
    before = float(baseline.loro_cost.sum())
    pieces = len(baseline.loro_cost) * channels
    unit = cost_unit(float(costs[0]), pieces) if len(costs) else 1.0
    odds = odds_against_best(costs, unit) if len(costs) else costs
    # What does it only at an end of its range is not what is missing, but something like it is.
    rivals = [
        i
        for i, one in enumerate(ranked)
        if (odds[i] >= RIVAL_ODDS or _fits_far_better(one, ranked[0]))
        and 1.0 - costs[i] / before >= (LARGER_SHARE if one.beyond_usual else null_q99)
        and not one.is_ordinary
        and not out_of_range(one, 1.0 - costs[i] / before)
    ]
    first = rivals[0] if rivals else 0
    gain = before - costs[first] if len(costs) else 0.0
    share = gain / before
    much = gain > LATER_SHARE * at_first or share >= LATER_MOST
    enough = share >= max(LEAST_SHARE, null_q99) and gain > LEAST_GAIN * unit and much
    keys = [ranked[i].added[-1] for i in rivals]
    named = bool(keys) and enough and not _of_any_sensor(keys)
    named = named and _helps(ranked[first], baseline) and _explains(ranked[first], baseline)
    return SelectionRound(
        baseline,
        tuple(ranked),
        tuple(float(odd) for odd in odds / max(odds.sum(), 1e-300)),
        float(share if named or not len(costs) else 1.0 - costs[0] / before),
        null_q99,
        tuple(keys) if named else (),
        above_tolerance(baseline),
    )
