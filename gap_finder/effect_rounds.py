"""Effects, one after another, and two at once where that leaves too much."""

from __future__ import annotations

from collections.abc import Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, replace

import numpy as np

from gap_finder.calibrate import Progress
from gap_finder.candidates import Candidate, as_tried, candidates, missing_effects
from gap_finder.description_rounds import LONG_ODDS, SETTLED
from gap_finder.design import RunSensitivities
from gap_finder.driver_choice import on_its_driver, other_drivers
from gap_finder.keys import law_of
from gap_finder.null_distribution import null_quantile
from gap_finder.observations import Observations
from gap_finder.pairs import ProposedPair, both_needed, screened_pairs
from gap_finder.refit import CandidateFit, fit_candidate
from gap_finder.screen import NormalMatrices, ResidualSets, Screen
from gap_finder.search import Search
from gap_finder.selection import (
    LEAST_SHARE,
    SelectionRound,
    above_tolerance,
    adequate,
    clearly_better,
    cost_per_run_and_channel,
    out_of_range,
    select_effect,
)
from gap_finder.swaps import swapped
from plant_model.effects import Effect
from plant_model.machine import Machine
from plant_model.parameters import FloatArray

REFITTED = 4
"""Effects that are calibrated in full, best of the screening first."""


@dataclass(frozen=True)
class Screened:
    """What a round tried, and how each did in the screening.

    Attributes
    ----------
    tried : list of Candidate
    best : dict of str to int
        Every effect's key and its best candidate, those first that explain most.
    scale : array, shape (m,)
        By how much each candidate's answer is scaled.
    loro_cost : array, shape (R, m)
        What each leaves of every run predicted from the others.
    null_q99 : float
        99 % quantile of what the best of all explains where nothing is missing [1].
    """

    tried: list[Candidate]
    best: dict[str, int]
    scale: FloatArray
    loro_cost: FloatArray
    null_q99: float


def select_effects(
    pool: Executor,
    started: CandidateFit,
    sensitivities: Sequence[RunSensitivities],
    search: Search,
    progress: Progress,
) -> tuple[list[SelectionRound], CandidateFit]:
    """Look for effects, one after another; then, if too much is left, for two at once.

    Parameters
    ----------
    pool : Executor
    started : CandidateFit
        With no effect added.
    sensitivities : sequence of RunSensitivities
        About its machine.
    search : Search
    progress : callable
        Told what is being done.

    Returns
    -------
    rounds : list of SelectionRound
        One judgement for each effect asked for.
    after : CandidateFit
        With those that were named.
    """
    known, rounds, after = _one_by_one(pool, started, sensitivities, search, progress)
    if above_tolerance(after) and search.most_effects > 1 and len(after.added) <= 2:
        _, screened = known
        pairs = screened_pairs(started, screened.tried, screened.best, after.added, search.seed)
        for pair in pairs:
            found = _both(pool, started, sensitivities, known, pair, search, progress)
            if found and clearly_better(found[1], after, LONG_ODDS):
                rounds, after = found
                break
    if not adequate(started, after):
        rounds, after = [replace(rounds[0], one_of=())], started
    return rounds, after


def _one_by_one(
    pool: Executor,
    started: CandidateFit,
    sensitivities: Sequence[RunSensitivities],
    search: Search,
    progress: Progress,
) -> tuple[tuple[SelectionRound, Screened], list[SelectionRound], CandidateFit]:
    """Look for effects until none is named, little is left, or there are as many as asked for.

    Returns the first round as it was judged, all rounds as they were in the end, and the fit.
    """
    at_first = float(started.loro_cost.sum())
    known = _round(pool, started, sensitivities, at_first, search, progress)
    rounds, after = [known[0]], started
    while rounds[-1].named:
        progress("calibrating the named effect in full")
        rounds[-1], grown, sensitivities = on_its_driver(pool, rounds[-1])
        share = 1.0 - float(grown.loro_cost.sum()) / float(after.loro_cost.sum())
        if out_of_range(grown, share):
            rounds[-1] = replace(rounds[-1], one_of=())
            break
        after = grown
        if len(rounds) > 1:
            progress("asking again which of the first it is")
            rounds[0], after = swapped(rounds[0], after, sensitivities)
        settled = cost_per_run_and_channel(after) < SETTLED
        if settled or len(rounds) == search.most_effects:
            break
        one, _ = _round(pool, after, sensitivities, at_first, search, progress)
        rounds.append(one)
    return known, rounds, after


def _both(
    pool: Executor,
    started: CandidateFit,
    sensitivities: Sequence[RunSensitivities],
    known: tuple[SelectionRound, Screened],
    pair: ProposedPair,
    search: Search,
    progress: Progress,
) -> tuple[list[SelectionRound], CandidateFit] | None:
    """Put the first of a proposed pair into force whatever it explains, and look for the second.

    Returns the two rounds and what is explained then; None if they are not named together.
    """
    selection, screened = known
    at_first, channels = float(started.loro_cost.sum()), len(started.observed[0].channels)
    positions = (pair.first, pair.second)
    key, other = (screened.tried[i].key for i in positions)
    progress(f"trying {key} together with {other}")
    calibrated = {one.added[-1] for one in selection.fits}
    places = [i for i in positions if screened.tried[i].key not in calibrated]
    more = _calibrated(pool, started, sensitivities, screened, places, progress)
    fits = [*selection.fits, *more]
    selection = select_effect(started, fits, selection.null_q99, channels)
    selection, alone, sensitivities = on_its_driver(pool, replace(selection, one_of=(key,)))
    second, _ = _round(pool, alone, sensitivities, at_first, search, progress)
    if not second.named:
        return None
    second, after, sensitivities = on_its_driver(pool, second)
    share = 1.0 - float(after.loro_cost.sum()) / at_first
    if out_of_range(after, share) or share < max(LEAST_SHARE, pair.null_q99):
        return None
    rest = [one.added[-1] for one in fits if one.added[-1] not in selection.one_of]
    selection = replace(selection, one_of=(*selection.one_of, *rest), null_q99=pair.null_q99)
    selection, after = swapped(selection, after, sensitivities)
    laws = {law_of(key) for key in after.added}
    singles = [one for one in fits if law_of(one.added[-1]) in laws]
    if not both_needed(after, [alone, *singles], at_first):
        return None
    return [selection, second], after


def _round(
    pool: Executor,
    baseline: CandidateFit,
    sensitivities: Sequence[RunSensitivities],
    at_first: float,
    search: Search,
    progress: Progress,
) -> tuple[SelectionRound, Screened]:
    """Look for one more effect."""
    screened = _screened(pool, baseline, search, progress)
    chosen = _shortlist(screened.best)
    explained = _calibrated(pool, baseline, sensitivities, screened, chosen, progress)
    more = other_drivers(explained, baseline, screened.null_q99, screened.best)
    explained += _calibrated(pool, baseline, sensitivities, screened, more, progress)
    channels = len(baseline.observed[0].channels)
    return select_effect(baseline, explained, screened.null_q99, channels, at_first), screened


def _screened(
    pool: Executor, baseline: CandidateFit, search: Search, progress: Progress
) -> Screened:
    """Try every effect that is not in force at every size and shape."""
    observed = baseline.observed
    effects = missing_effects(baseline.machine, search.without)
    tried: list[Candidate] = []
    jobs = [pool.submit(_candidates, baseline.machine, observed, effect.name) for effect in effects]
    for effect, job in zip(effects, jobs, strict=True):
        progress(f"screening {effect.name}")
        tried += job.result()
    screen = Screen(NormalMatrices.of(baseline.designs, tried))
    residuals = [design.residual[None] for design in baseline.designs]
    scores = screen.scores(ResidualSets.of(baseline.designs, tried, residuals, baseline.position()))
    gain = scores.loro_gain[0].sum(axis=0)
    best: dict[str, int] = {}
    for i in np.argsort(-gain):
        best.setdefault(tried[i].key, int(i))
    null_q99 = null_quantile(
        screen, baseline.designs, observed, tried, float(baseline.loro_cost.sum()), search.seed
    )
    left = scores.loro_cost[0][:, None] - scores.loro_gain[0]
    return Screened(tried, best, scores.scale[0], left, null_q99)


def _calibrated(
    pool: Executor,
    baseline: CandidateFit,
    sensitivities: Sequence[RunSensitivities],
    screened: Screened,
    some: Sequence[int],
    progress: Progress,
) -> list[CandidateFit]:
    """Calibrate anew with each of some candidates, by position."""
    tried = screened.tried
    jobs = [
        pool.submit(
            fit_candidate,
            baseline,
            tried[i],
            float(screened.scale[i]),
            screened.loro_cost[:, i],
            sensitivities,
            as_tried(tried, tried[i]),
        )
        for i in some
    ]
    explained = []
    for i, job in zip(some, jobs, strict=True):
        progress(f"calibrating with {tried[i].key}")
        explained.append(job.result())
    return explained


def _shortlist(best: dict[str, int]) -> list[int]:
    """Return the positions of the best effects, each on the driver that does most.

    Parameters
    ----------
    best : dict of str to int
        Keys and where each does most, the best first.
    """
    found: dict[str, int] = {}
    for key, i in best.items():
        found.setdefault(law_of(key), i)
    return list(found.values())[:REFITTED]


def _candidates(machine: Machine, observed: Sequence[Observations], name: str) -> list[Candidate]:
    effect: type[Effect] = next(e for e in missing_effects(machine) if e.name == name)
    return list(candidates(machine, observed, effect))
