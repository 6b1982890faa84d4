"""Selects the candidates for full scoring, by a linear screening about the calibrated machine.

A candidate is one more unknown of all runs: its response times a factor. Everything is linear, as
in the score.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.linalg import cho_solve

from gap_finder.added_paths import AT_ONCE
from gap_finder.candidates import LEAST_SCALE, MOST_SCALE
from gap_finder.design import RunDesign, RunSensitivities, design_of, told_by_one_run
from gap_finder.hypotheses import Addition, Listed
from gap_finder.keys import bodies_of, effect_of, place_of
from gap_finder.kinds import kinds
from gap_finder.leave_one_out import LeaveOneOut, Runs
from gap_finder.priors import Priors
from gap_finder.score import Fit, Units
from plant_model.effect_names import name_of
from plant_model.machine import Machine
from plant_model.parameters import FloatArray

LEADERS = 6
"""Candidates that are calibrated to the end, however little they gain at first; places at which the
best kind of change is scored; and rivals tried for each addition once another has been added. Set
for time, on no data. Half of the places at most are cells of the same bodies, because neighbours
respond alike and would leave no room for any other place."""


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
        A few places of every kind of change and drivers of every law, and all bodies that the
        likeliest misplaced thermometer may read, to be scored if that kind does best.
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
    likely += _other_sizes(tried, order, likely)
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


def _other_sizes(
    tried: Sequence[Addition], order: Sequence[int], likely: Sequence[int]
) -> list[int]:
    """Return the next few sizes of the laws that calibration cannot size: their responses leap."""
    more = []
    for i in likely:
        effect = effect_of(tried[i].key)
        if effect is not None and effect.settles:
            alike = [j for j in order if tried[j].key == tried[i].key and j != i]
            more += alike[: LEADERS - 1]
    return more


def places_of(
    tried: Sequence[Addition], order: Sequence[int], body: Mapping[str, str]
) -> list[int]:
    """Return the positions of the first few places or drivers of every kind.

    Of a kind that acts on a channel, all bodies for the first one's channel.
    """
    keys: set[str] = set()
    channels: dict[str, str] = {}
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
        if effect is None and kinds()[kind].on_channel:
            # It does not tell apart the bodies that they may read: calibration hides that best.
            channel = place_of(key)[0]
            wanted = channels.setdefault(kind, channel) == channel
        else:
            wanted = of_kind[kind] < LEADERS
        if wanted and of_bodies[where] < LEADERS // 2:
            keys.add(key)
            of_kind[kind] += 1
            of_bodies[where] += 1
            chosen.append(i)
    return chosen


@dataclass(frozen=True)
class Scores:
    """What each candidate leaves, with each run predicted from the others.

    Attributes
    ----------
    left : array, shape (m, C)
        Squared error of each channel over all runs, in the designs' units.
    numbers_gain, others_gain : array, shape (m,)
        Reduction of the squared distance of the file's numbers from their priors' centres, and of
        that of all other shared unknowns.
    scale : array, shape (m,)
        Factor on the candidate's response, from all runs together.
    position : array, shape (m, P)
        Where calibration then goes, in the fitting scale.
    """

    left: FloatArray
    numbers_gain: FloatArray
    others_gain: FloatArray
    scale: FloatArray
    position: FloatArray


class Screen:
    """Scores candidates.

    Parameters
    ----------
    runs : LeaveOneOut
    tried : sequence of Addition, length m
    channels : int
    """

    def __init__(self, runs: LeaveOneOut, tried: Sequence[Addition], channels: int) -> None:
        self._runs, self._tried, self._channels = runs, tried, channels
        count, many = len(runs.designs), len(tried)
        # Of every run: responses against the shared columns, themselves and the residual.
        self._cross = np.zeros((count, len(runs.position), many))
        self._squares, self._against = np.zeros((count, many)), np.zeros((count, many))
        for i, (design, shared) in enumerate(zip(runs.designs, runs.clean, strict=True)):
            residual = design.cleaned(design.residual[:, None])[:, 0]
            for block, columns in _in_blocks(tried, i, design):
                self._cross[i, :, block] = shared.T @ columns
                self._squares[i, block] = np.sum(columns * design.cleaned(columns), axis=0)
                self._against[i, block] = residual @ columns
        self._alone = told_by_one_run(self._squares)

    def scores(self) -> Scores:
        """Score every candidate."""
        runs = self._runs
        step, follow, scale = self._recalibrated(runs.every)
        reached = (runs.position + step)[:, None]
        with_it = reached - scale * follow
        gain = reached**2 - with_it**2
        numbers, others = (part.sum(axis=0) for part in np.split(gain, [runs.calibrated]))
        left = sum(self._predicted(run) for run in runs.every.tolist())
        return Scores(np.asarray(left), numbers, others, scale, with_it[: runs.calibrated].T)

    def _recalibrated(self, kept: Runs) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return what some runs make of the unknowns.

        The shared ones' step without any candidate, (Q,), by how much they move back per unit of
        each candidate, (Q, m), and the candidates' factors, (m,).
        """
        factor, step = self._runs.recalibrated(kept)
        cross = self._cross[kept].sum(axis=0)
        follow = cho_solve(factor, cross)
        squares = self._squares[kept].sum(axis=0) - np.sum(cross * follow, axis=0)
        slope = self._against[kept].sum(axis=0) + step @ cross
        scale = np.clip(-slope / np.maximum(squares, 1e-12), LEAST_SCALE, MOST_SCALE)
        return step, follow, scale

    def _predicted(self, run: int) -> FloatArray:
        """Return the squared error of a left-out run's channels with each candidate, (m, C)."""
        design = self._runs.designs[run]
        step, follow, scale = self._recalibrated(self._runs.without(run))
        base = (design.residual + design.shared @ step)[:, None]
        clean = design.cleaned(base)
        left = np.zeros((len(scale), self._channels))
        for block, columns in _in_blocks(self._tried, run, design):
            columns -= design.shared @ follow[:, block]
            cleaned = design.cleaned(columns)
            # A candidate that acts only in this run is the run's own unknown, like a zero.
            quadratic = np.maximum(np.sum(columns * cleaned, axis=0), 1e-12)
            best = np.clip(-np.sum(base * cleaned, axis=0) / quadratic, LEAST_SCALE, MOST_SCALE)
            size = np.where(self._alone[run, block], best, scale[block])
            squares = (base + columns * size) * (clean + cleaned * size)
            left[block] = squares.reshape(-1, self._channels, len(size)).sum(axis=0).T
        return left


def _in_blocks(
    tried: Sequence[Addition], run: int, design: RunDesign
) -> Iterator[tuple[slice, FloatArray]]:
    """Yield some candidates, and a run's robustly weighted responses to them, (N, b).

    All responses to the thousands of changes of a page would fill the memory.
    """
    for begin in range(0, len(tried), AT_ONCE):
        block = slice(begin, begin + AT_ONCE)
        answers = np.array([candidate.answers[run] for candidate in tried[block]])
        yield block, answers.T * design.weight[:, None]
