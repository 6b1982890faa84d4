"""Looking for what the description of a machine lacks: every kind of change at every place.

Changes are judged by the rules of effects: chance, the runs that they help, and how they compare
with each other. One that explains most of all that is left is named for that. One that is about a
single part explains little of all that two dozen sensors show; it is named if it explains most of
what is left of one channel, and of everything more than chance does.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, replace

import numpy as np

from plant_model.gap.by_channel import by_channel, unseen_by_channel
from plant_model.gap.candidates import Candidate
from plant_model.gap.description import Described
from plant_model.gap.design import Surroundings
from plant_model.gap.judge import ABOVE_TOLERANCE, ADEQUATE, MOST_RUNS, Judged, judge, left_over
from plant_model.gap.kinds import Change, Known, kinds
from plant_model.gap.nothing_missing import best_share, drawn_like
from plant_model.gap.observations import Observations
from plant_model.gap.refit import Explained, explain
from plant_model.gap.screen import Data, Grams, Scores, Screen
from plant_model.integrate import IntegrationError
from plant_model.parameters import FloatArray

LEAST_SHARE = 0.5
"""Share of what is left on unseen runs that a change must explain, of all or of one channel [1]:
the best of some 260 heat paths explained up to 32 % of losses that no catalogue held."""

NEARLY = 0.7
"""Share of that limit from which a screened change is calibrated in full: it is screened at a few
sizes only [1]."""

REFITTED = 14
"""Changes that are calibrated in full: near each other they look alike while they are small."""

ONLY = 1e-6
"""An answer that is nowhere larger than this is none [tolerances]."""


@dataclass(frozen=True)
class _Tried:
    """What is tried: a change at some of its numbers, and its answers in every run."""

    change: Change
    numbers: dict[str, float]
    candidate: Candidate


@dataclass(frozen=True)
class _Promising:
    """A change that the screening lets through, and the channel where it does most; -1: any."""

    tried: _Tried
    scale: float
    channel: int


def look(
    pool: Executor,
    now: Explained,
    around: Sequence[Surroundings],
    seed: int,
    *,
    only: Collection[str] = (),
    least: float = LEAST_SHARE,
    locally: bool = True,
) -> tuple[Described | None, Explained]:
    """Look for one change of the description.

    Parameters
    ----------
    pool : Executor
    now : Explained
    around : sequence of Surroundings
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
    described : Described or None
        What was named.
    after : Explained
        Calibrated anew with it, or *now*.
    """
    tried = _all_tried(pool, now, around, only)
    if not tried:
        return None, now
    promising, chances = _screened(now, tried, seed, least, locally=locally)
    if not promising:
        return None, now
    jobs = [pool.submit(_explained, now, one, around) for one in promising]
    fitted = [
        (one, found)
        for one, found in zip(promising, (job.result() for job in jobs), strict=True)
        if found is not None
    ]
    return _judged(now, fitted, chances, least)


def far_off(now: Explained) -> bool:
    """Tell whether some channel is wrong by itself by so much that something must be missing."""
    channels = len(now.observed[0].channels)
    left = unseen_by_channel(now.designs, now.pull(), channels).sum(axis=0)
    return bool(np.any(left > ADEQUATE * _runs_with(now.observed)))


def _all_tried(
    pool: Executor, now: Explained, around: Sequence[Surroundings], only: Collection[str]
) -> list[_Tried]:
    known = [Known(now.machine, one, part) for one, part in zip(now.observed, around, strict=True)]
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
                    tried.append(_Tried(change, numbers, Candidate(change.key, {}, answers)))
    return tried


def _answers(known: Known, changes: dict[str, list[Change]]) -> dict[str, list[FloatArray]]:
    """Return what every change of every kind changes in a run."""
    return {name: kinds()[name].answers(some, known) for name, some in changes.items()}


def _screened(
    now: Explained, tried: Sequence[_Tried], seed: int, least: float, *, locally: bool
) -> tuple[list[_Promising], tuple[float, float]]:
    """Return the changes worth calibrating, and what chance explains of all and of one channel."""
    names = now.observed[0].channels
    candidates = [one.candidate for one in tried]
    screen = Screen(Grams.of(now.designs, candidates))
    residuals = [design.residual[None] for design in now.designs]
    data = Data.of(now.designs, candidates, residuals, now.pull())
    scores = screen.scores(data)
    gain, before = scores.unseen[0].sum(axis=0), float(now.unseen.sum())
    left = unseen_by_channel(now.designs, now.pull(), len(names)).sum(axis=0)
    wrong = np.flatnonzero(left > ABOVE_TOLERANCE * _runs_with(now.observed))
    some = [int(i) for i in wrong] if locally else []
    here = np.zeros((1, len(tried)))
    if some:
        told = by_channel(screen, now.designs, candidates, residuals, data, len(names), some)
        here = told.share[0]
    enough = (gain >= NEARLY * least * before) | (
        (here.max(axis=0) >= NEARLY * least) & (gain > 0.0)
    )
    if not enough.any():
        return [], (0.0, 0.0)
    drawn = drawn_like(screen, now.designs, now.observed, candidates, before, seed)
    drawn_data = Data.of(now.designs, candidates, drawn)
    chance = best_share(screen, drawn_data), 0.0
    if some:
        by_luck = by_channel(screen, now.designs, candidates, drawn, drawn_data, len(names), some)
        chance = chance[0], float(np.quantile(by_luck.share.max(axis=(1, 2)), 0.99))
    return _promising(scores, tried, enough, (gain / before, here), some, least), chance


def _promising(
    scores: Scores,
    tried: Sequence[_Tried],
    enough: FloatArray,
    shares: tuple[FloatArray, FloatArray],
    some: Sequence[int],
    least: float,
) -> list[_Promising]:
    """Return the best numbers of the best changes, those that explain most of all first."""
    of_all, here = shares
    found: dict[str, _Promising] = {}
    for k in np.argsort(-of_all).tolist():
        key = tried[k].change.key
        if not enough[k] or key in found:
            continue
        channel = some[int(np.argmax(here[:, k]))] if some else -1
        found[key] = _Promising(tried[k], float(scores.scale[0, k]), channel)
    return list(found.values())[:REFITTED]


def _runs_with(observed: Sequence[Observations]) -> FloatArray:
    """Return in how many runs each channel was measured, shape (C,)."""
    measured = [np.isfinite(one.values).any(axis=0) for one in observed]
    return np.asarray(np.sum(measured, axis=0, dtype=np.float64))


def _explained(now: Explained, one: _Promising, around: Sequence[Surroundings]) -> Explained | None:
    """Calibrate anew with a change."""
    change = one.tried.change
    numbers = change.scaled(one.tried.numbers, one.scale)
    base, start = (change.put_into(machine, numbers) for machine in (now.base, now.machine))
    try:
        found = explain(base, (*now.added, change.key), now.observed, [start], around)
    except IntegrationError:
        return None
    return replace(found, acts=one.tried.candidate.acts)


def _judged(
    now: Explained,
    fitted: Sequence[tuple[_Promising, Explained]],
    chances: tuple[float, float],
    least: float,
) -> tuple[Described | None, Explained]:
    channels = len(now.observed[0].channels)
    for channel in dict.fromkeys([-1, *(one.channel for one, _ in fitted)]):
        some = {
            one.tried.change.key: (one.tried.change, found)
            for one, found in fitted
            if channel in (-1, one.channel)
        }
        explained = [found for _, found in some.values()]
        if channel < 0:
            judged = judge(now, explained, max(least, chances[0]), channels)
            judged = replace(judged, chance=chances[0])
        else:
            judged = judge_in(now, explained, channel, chances, least)
        if judged.named:
            change, found = some[judged.one_of[0]]
            after = replace(found, added=now.added)
            name = now.observed[0].channels[channel] if channel >= 0 else ""
            return Described(change, judged, after, name), after
    return None, now


def judge_in(
    now: Explained,
    tried: Sequence[Explained],
    channel: int,
    chances: tuple[float, float],
    least: float,
) -> Judged:
    """Judge changes by what they explain of one channel.

    Parameters
    ----------
    now : Explained
    tried : sequence of Explained
        Each with one more change.
    channel : int
        Its position.
    chances : pair of float
        What the best of all candidates explains by chance in 99 of 100 cases, of everything and of
        the channel where it does most [1].
    least : float
        Share of the channel that a change must explain [1].

    Notes
    -----
    The rules are those of :func:`plant_model.gap.judge.judge`, asked of the channel. Besides, a
    change must explain more of everything than chance does.
    """
    channels = len(now.observed[0].channels)
    before = _left_in(now, channels)[:, channel]
    all_before = float(now.unseen.sum())
    good = []
    for one in tried:
        of_all = 1.0 - float(one.unseen.sum()) / all_before
        here = _left_in(one, channels)[:, channel]
        helped = np.mean((here < before)[list(one.acts)]) if any(one.acts) else 0.0
        share = 1.0 - float(here.sum()) / float(before.sum())
        if of_all >= chances[0] and share >= max(least, chances[1]) and helped >= MOST_RUNS:
            good.append(replace(one, unseen=here))
    judged = judge(replace(now, unseen=before), good, max(least, chances[1]), 1)
    whole = {one.added[-1]: one for one in tried}
    return replace(
        judged,
        now=now,
        chance=chances[1],
        tried=tuple(whole[one.added[-1]] for one in judged.tried),
        above_tolerance=left_over(now, channels) > ABOVE_TOLERANCE,
    )


def _left_in(one: Explained, channels: int) -> FloatArray:
    return unseen_by_channel(one.designs, one.pull(), channels)
