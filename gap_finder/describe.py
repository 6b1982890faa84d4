"""Looking for what the description of a machine lacks: every kind of change at every place.

Changes are selected by the rules of effects: the null distribution, the runs that they help, and
how they compare with each other. One that explains most of all that is left is named for that. One
that is about a single part explains little of all that two dozen sensors show; it is named if it
explains most of what is left of one channel, and of everything more than chance does.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, replace

import numpy as np

from gap_finder.by_channel import by_channel, unseen_by_channel
from gap_finder.candidates import Candidate
from gap_finder.description import NamedChange
from gap_finder.design import RunSensitivities
from gap_finder.kinds import CalibratedRun, Change, kinds
from gap_finder.null_distribution import best_share_q99, null_residuals
from gap_finder.observations import Observations
from gap_finder.refit import CandidateFit, fit_effects
from gap_finder.screen import NormalMatrices, ResidualSets, Scores, Screen
from gap_finder.selection import (
    ABOVE_TOLERANCE,
    MOST_RUNS,
    RIVAL_ODDS,
    SelectionRound,
    above_tolerance,
    odds_among,
    select_effect,
)
from plant_model.integrate import IntegrationError
from plant_model.parameters import FloatArray

LEAST_SHARE = 0.5
"""Share of the leave-one-run-out cost that a change must explain, of all or of one channel [1]:
the best of some 260 heat paths explained up to 32 % of losses that no catalogue held."""

NEARLY = 0.7
"""Share of that limit from which a screened change is calibrated in full: it is screened at a few
sizes only [1]."""

REFITTED = 14
"""Changes that are calibrated in full: near each other they look alike while they are small."""

FAR_OFF = 5.0
"""Cost per run of one channel from which something must be missing, whatever the others say."""

ONLY = 1e-6
"""An answer that is nowhere larger than this is none [tolerances]."""


@dataclass(frozen=True)
class _Trial:
    """What is tried: a change at some of its numbers, and its answers in every run."""

    change: Change
    numbers: dict[str, float]
    candidate: Candidate


@dataclass(frozen=True)
class _Shortlisted:
    """A change that the screening lets through, and the channel where it does most; -1: any."""

    trial: _Trial
    scale: float
    channel: int


def select_change(
    pool: Executor,
    baseline: CandidateFit,
    sensitivities: Sequence[RunSensitivities],
    seed: int,
    *,
    only: Collection[str] = (),
    least: float = LEAST_SHARE,
    locally: bool = True,
) -> tuple[NamedChange | None, CandidateFit]:
    """Look for one change of the description.

    Parameters
    ----------
    pool : Executor
    baseline : CandidateFit
    sensitivities : sequence of RunSensitivities
        About its machine.
    seed : int
        Of the draws in which nothing is missing.
    only : collection of str
        Kinds to try; all if empty.
    least : float
        Share that a change must explain [1].
    locally : bool
        Whether it may be that of one channel.

    Returns
    -------
    change : NamedChange or None
        What was named.
    after : CandidateFit
        Calibrated anew with it, or *baseline*.
    """
    tried = _all_tried(pool, baseline, sensitivities, only)
    if not tried:
        return None, baseline
    shortlist, null_q99s = _screened(baseline, tried, seed, least, locally=locally)
    if not shortlist:
        return None, baseline
    jobs = [pool.submit(_explained, baseline, one, sensitivities) for one in shortlist]
    fitted = [
        (one, found)
        for one, found in zip(shortlist, (job.result() for job in jobs), strict=True)
        if found is not None
    ]
    return _selected(baseline, fitted, null_q99s, least)


def far_off(baseline: CandidateFit) -> bool:
    """Tell whether some channel is wrong by itself by so much that something must be missing."""
    channels = len(baseline.observed[0].channels)
    left = unseen_by_channel(baseline.designs, baseline.position(), channels).sum(axis=0)
    return bool(np.any(left > FAR_OFF * _runs_with(baseline.observed)))


def _all_tried(
    pool: Executor,
    baseline: CandidateFit,
    sensitivities: Sequence[RunSensitivities],
    only: Collection[str],
) -> list[_Trial]:
    known = [
        CalibratedRun(baseline.machine, one, part)
        for one, part in zip(baseline.observed, sensitivities, strict=True)
    ]
    changes = {
        name: list(kind.all_of(known)) for name, kind in kinds().items() if not only or name in only
    }
    jobs = [pool.submit(_answers, one, changes) for one in known]
    by_run = [job.result() for job in jobs]
    tried = []
    for name, some in changes.items():
        for i, change in enumerate(some):
            for j, numbers in enumerate(change.points()):
                answers = tuple(run[name][i][j] for run in by_run)
                if max(float(np.abs(one).max()) for one in answers) > ONLY:
                    tried.append(_Trial(change, numbers, Candidate(change.key, {}, answers)))
    return tried


def _answers(known: CalibratedRun, changes: dict[str, list[Change]]) -> dict[str, list[FloatArray]]:
    """Return what every change of every kind changes in a run."""
    return {name: kinds()[name].answers(some, known) for name, some in changes.items()}


def _screened(
    baseline: CandidateFit, tried: Sequence[_Trial], seed: int, least: float, *, locally: bool
) -> tuple[list[_Shortlisted], tuple[float, float]]:
    """Return the changes worth calibrating, and what chance explains of all and of one channel."""
    names = baseline.observed[0].channels
    candidates = [one.candidate for one in tried]
    screen = Screen(NormalMatrices.of(baseline.designs, candidates))
    residuals = [design.residual[None] for design in baseline.designs]
    data = ResidualSets.of(baseline.designs, candidates, residuals, baseline.position())
    scores = screen.scores(data)
    gain, before = scores.loro_gain[0].sum(axis=0), float(baseline.loro_cost.sum())
    left = unseen_by_channel(baseline.designs, baseline.position(), len(names)).sum(axis=0)
    wrong = np.flatnonzero(left > ABOVE_TOLERANCE * _runs_with(baseline.observed))
    some = [int(i) for i in wrong] if locally else []
    here = np.zeros((1, len(tried)))
    if some:
        told = by_channel(screen, baseline.designs, candidates, residuals, data, len(names), some)
        here = told.share[0]
    enough = (gain >= NEARLY * least * before) | (
        (here.max(axis=0) >= NEARLY * least) & (gain > 0.0)
    )
    if not enough.any():
        return [], (0.0, 0.0)
    drawn = null_residuals(screen, baseline.designs, baseline.observed, candidates, before, seed)
    drawn_data = ResidualSets.of(baseline.designs, candidates, drawn)
    null_q99 = best_share_q99(screen, drawn_data), 0.0
    if some:
        by_luck = by_channel(
            screen, baseline.designs, candidates, drawn, drawn_data, len(names), some
        )
        null_q99 = null_q99[0], float(np.quantile(by_luck.share.max(axis=(1, 2)), 0.99))
    return _shortlisted(scores, tried, enough, (gain / before, here), some, least), null_q99


def _shortlisted(
    scores: Scores,
    tried: Sequence[_Trial],
    enough: FloatArray,
    shares: tuple[FloatArray, FloatArray],
    some: Sequence[int],
    least: float,
) -> list[_Shortlisted]:
    """Return the best numbers of the best changes, those that explain most of all first."""
    of_all, here = shares
    found: dict[str, _Shortlisted] = {}
    for k in np.argsort(-of_all).tolist():
        key = tried[k].change.key
        if not enough[k] or key in found:
            continue
        channel = some[int(np.argmax(here[:, k]))] if some else -1
        found[key] = _Shortlisted(tried[k], float(scores.scale[0, k]), channel)
    return list(found.values())[:REFITTED]


def _runs_with(observed: Sequence[Observations]) -> FloatArray:
    """Return in how many runs each channel was measured, shape (C,)."""
    measured = [np.isfinite(one.values).any(axis=0) for one in observed]
    return np.asarray(np.sum(measured, axis=0, dtype=np.float64))


def _explained(
    baseline: CandidateFit, one: _Shortlisted, sensitivities: Sequence[RunSensitivities]
) -> CandidateFit | None:
    """Calibrate anew with a change."""
    change = one.trial.change
    numbers = change.scaled(one.trial.numbers, one.scale)
    base, start = (
        change.put_into(machine, numbers) for machine in (baseline.base, baseline.machine)
    )
    try:
        found = fit_effects(
            base, (*baseline.added, change.key), baseline.observed, [start], sensitivities
        )
    except IntegrationError:
        return None
    return replace(found, acts=one.trial.candidate.acts)


def _selected(
    baseline: CandidateFit,
    fitted: Sequence[tuple[_Shortlisted, CandidateFit]],
    null_q99s: tuple[float, float],
    least: float,
) -> tuple[NamedChange | None, CandidateFit]:
    channels = len(baseline.observed[0].channels)
    for channel in dict.fromkeys([-1, *(one.channel for one, _ in fitted)]):
        some = {
            one.trial.change.key: (one.trial.change, found)
            for one, found in fitted
            if channel in (-1, one.channel)
        }
        explained = [found for _, found in some.values()]
        if channel < 0:
            selection = select_effect(baseline, explained, max(least, null_q99s[0]), channels)
            selection = replace(selection, null_q99=null_q99s[0])
        else:
            selection = select_for_channel(baseline, explained, channel, null_q99s, least)
        if selection.named:
            change, found = some[selection.one_of[0]]
            after = replace(found, added=baseline.added)
            name = baseline.observed[0].channels[channel] if channel >= 0 else ""
            return NamedChange(change, selection, after, name), after
    return None, baseline


def select_for_channel(
    baseline: CandidateFit,
    tried: Sequence[CandidateFit],
    channel: int,
    null_q99s: tuple[float, float],
    least: float,
) -> SelectionRound:
    """Judge changes by what they explain of one channel.

    Parameters
    ----------
    baseline : CandidateFit
    tried : sequence of CandidateFit
        Each with one more change.
    channel : int
        Its position.
    null_q99s : pair of float
        Null 99 % quantiles: what the best of all candidates explains of everything, and of the
        channel where it does most, where nothing is missing [1].
    least : float
        Share of the channel that a change must explain [1].

    Notes
    -----
    The rules are those of :func:`gap_finder.selection.select_effect`, asked of the channel. A
    change must also explain more of everything than chance does. What the channel cannot tell
    apart, all channels together may.
    """
    channels = len(baseline.observed[0].channels)
    before = _left_in(baseline, channels)[:, channel]
    all_before = float(baseline.loro_cost.sum())
    good = []
    for one in tried:
        of_all = 1.0 - float(one.loro_cost.sum()) / all_before
        here = _left_in(one, channels)[:, channel]
        helped = np.mean((here < before)[list(one.acts)]) if any(one.acts) else 0.0
        share = 1.0 - float(here.sum()) / float(before.sum())
        if of_all >= null_q99s[0] and share >= max(least, null_q99s[1]) and helped >= MOST_RUNS:
            good.append(replace(one, loro_cost=here))
    selection = select_effect(
        replace(baseline, loro_cost=before), good, max(least, null_q99s[1]), 1
    )
    whole = {one.added[-1]: one for one in tried}
    chosen = replace(
        selection,
        baseline=baseline,
        null_q99=null_q99s[1],
        fits=tuple(whole[one.added[-1]] for one in selection.fits),
        above_tolerance=above_tolerance(baseline),
    )
    if not selection.named:
        return chosen
    odds = odds_among({key: whole[key] for key in selection.one_of})
    weights = np.array([odds.get(one.added[-1], 0.0) for one in selection.fits])
    chosen = replace(
        chosen,
        probability=tuple((weights / weights.sum()).tolist()),
        one_of=tuple(key for key, odd in odds.items() if odd >= RIVAL_ODDS),
    )
    here = next(one for one in good if one.added[-1] == chosen.one_of[0]).loro_cost
    return replace(chosen, explained_share=1.0 - float(here.sum()) / float(before.sum()))


def _left_in(one: CandidateFit, channels: int) -> FloatArray:
    return unseen_by_channel(one.designs, one.position(), channels)
