"""The gap finder: calibrate, screen what may be missing, refit the best, judge, answer."""

from __future__ import annotations

from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from threadpoolctl import threadpool_limits

from measurement.errors import BadInput
from measurement.runs import Run
from measurement.workers import workers as processes
from plant_model.effects import Effect
from plant_model.gap.calibrate import Progress, quiet
from plant_model.gap.candidates import Candidate, as_tried, candidates, missing_effects
from plant_model.gap.data_faults import DataFault
from plant_model.gap.describe import far_off, look
from plant_model.gap.description import Described
from plant_model.gap.description_rounds import SETTLED, describe, left_out
from plant_model.gap.design import Surroundings, all_surroundings
from plant_model.gap.judge import LEAST_SHARE, Judged, adequate, judge, left_over, out_of_range
from plant_model.gap.nothing_missing import chance_share
from plant_model.gap.observations import Observations
from plant_model.gap.periods import in_step
from plant_model.gap.reference import Reference
from plant_model.gap.refit import Explained, explain_with, refined, scored
from plant_model.gap.regimes import residuals
from plant_model.gap.screen import Data, Grams, Screen
from plant_model.gap.standing import calibrated
from plant_model.gap.swaps import swapped
from plant_model.machine import Machine

REFITTED = 4
"""Candidates that are calibrated in full, best of the screening first."""

MOST_ADDED = 2
"""Effects added at most, one after another."""

MOST_CHANGES = 6
"""Changes of the description made at most, if the user sets no other limit."""

FEWEST_RUNS = 3
"""Runs needed to predict each from the others and still see whether that is chance."""


@dataclass(frozen=True)
class Withdrawn:
    """An effect that was named and taken back.

    Attributes
    ----------
    key : str
    runs : tuple of str
        Those that have it, of the runs used.
    """

    key: str
    runs: tuple[str, ...]

    @classmethod
    def of(cls, best: Explained) -> Withdrawn:
        """Gather from the explanation that added it."""
        key = best.added[-1]
        return cls(key, tuple(one.run.name for one in best.observed if key not in one.absent))


@dataclass(frozen=True)
class Found:
    """What the gap finder found.

    Attributes
    ----------
    before, after : Explained
        The calibrated machine as it was given, and with what was added (the same if nothing was).
    rounds : tuple of Judged
        One judgement for each effect asked for.
    withdrawn : tuple of Withdrawn
        Effects that were taken back, because runs never used were worse with them.
    described : tuple of Described
        What of the description itself was changed: starts of parts, heat paths.
    faults : tuple of DataFault
        What was left out besides, because the calibrated machine says that it is broken.
    """

    before: Explained
    after: Explained
    rounds: tuple[Judged, ...]
    withdrawn: tuple[Withdrawn, ...] = ()
    described: tuple[Described, ...] = ()
    faults: tuple[DataFault, ...] = ()

    @property
    def observed(self) -> tuple[Observations, ...]:
        """What was compared, with what had not begun yet in each run."""
        return self.after.observed

    @cached_property
    def reference(self) -> Reference:
        """How well any model with these inputs could do on the runs used, after what was added."""
        machine = self.after.machine
        return Reference(
            machine, [residuals(machine, in_step(machine, one)) for one in self.observed]
        )

    @property
    def verdict(self) -> str:
        """``effect``, ``one_of``, ``none_missing`` or ``unknown``.

        What does not follow from the inputs in the same way in every run is not reducible, and may
        still be more than a lumped model is wrong by: then something is missing, too.
        """
        first = self.rounds[0]
        if not first.named and not self.described:
            wrong = first.above_tolerance or self.reference.is_left
            return "unknown" if wrong else "none_missing"
        several = any(len(entry.one_of) > 1 for entry in self.rounds) or any(
            one.or_else for one in self.described
        )
        return "one_of" if several else "effect"

    def only_described(self) -> Found:
        """Return what was found without the effects, the description as it was changed."""
        if not self.described:
            return replace(self, after=self.before)
        return replace(self, after=self.described[-1].after)

    def without_change(self, gone: Described) -> Found:
        """Return what was found without one change of the description, and without effects."""
        kept = left_out(self.before, self.described, gone)
        above = self.described[0].judged.above_tolerance
        first = replace(self.rounds[0], now=self.before, one_of=(), above_tolerance=above)
        taken = (*self.withdrawn, Withdrawn(gone.key, ()))
        left = replace(self, rounds=(first,), described=tuple(kept), withdrawn=taken)
        return left.only_described()

    def with_only(self, count: int) -> Found:
        """Return what was found with no more than the first *count* effects that were added."""
        named = [judged for judged in self.rounds if judged.named]
        if count >= len(named):
            return self
        gone = tuple(Withdrawn.of(judged.best) for judged in named[count:])
        last = self.rounds[count]
        # The second round may have changed which of a set the first is: what it began with counts.
        kept = [
            replace(judged, one_of=tuple(dict.fromkeys((key, *judged.one_of))))
            for judged, key in zip(self.rounds[:count], last.now.added, strict=True)
        ]
        rounds = (*kept, replace(last, one_of=()))
        return replace(self, after=last.now, rounds=rounds, withdrawn=gone)


def find_gap(
    machine: Machine,
    runs: Sequence[Run],
    *,
    without: Sequence[str] = (),
    most: int = MOST_CHANGES,
    bad: dict[str, list[tuple[str, float, float]]] | None = None,
    seed: int = 0,
    workers: int | None = None,
    progress: Progress = quiet,
) -> Found:
    """Find what is missing in a machine's model.

    Parameters
    ----------
    machine : Machine
    runs : sequence of Run
        At least three, of different speeds; their order does not matter.
    without : sequence of str
        Effects that are not to be considered.
    most : int
        Changes of the description made at most, one after another.
    bad : dict of run name to list of (channel, start, end), optional
        Spans of data to leave out [s].
    seed : int
        Of starting points and of the runs drawn with nothing missing.
    workers : int, optional
        Processes; by default one for each core.
    progress : callable
        Told what is being done.

    Raises
    ------
    BadInput
        When there are too few runs, or nothing in them excites the machine.
    """
    with threadpool_limits(1):
        return _find(machine, runs, without, most, bad, seed, workers, progress)


def _find(
    machine: Machine,
    runs: Sequence[Run],
    without: Sequence[str],
    most: int,
    bad: dict[str, list[tuple[str, float, float]]] | None,
    seed: int,
    workers: int | None,
    progress: Progress,
) -> Found:
    if len(runs) < FEWEST_RUNS:
        raise BadInput(
            "--runs", "", f"{len(runs)} given; {FEWEST_RUNS} or more are needed to name an effect"
        )
    ordered = sorted(runs, key=lambda run: run.name)
    _need_excitation(machine, ordered)
    calibration, observed, faults = calibrated(machine, ordered, bad, seed=seed, progress=progress)
    progress("what else may be wrong")
    around = all_surroundings(machine, calibration.machine, observed)
    before = scored(machine, (), observed, calibration, around)
    with processes(workers) as pool:
        progress("what starts at another temperature")
        restarted, started = look(
            pool, before, around, seed, only=("start_state",), least=LEAST_SHARE, locally=False
        )
        described = [restarted] if restarted else []
        rounds, after = _effects(pool, started, around, without, seed, progress)
        found = Found(before, after, tuple(rounds), (), tuple(described), tuple(faults))
        named = rounds[0].named
        # Not by the verdict: with another start of a part, that is an answer already.
        wrong = rounds[0].above_tolerance or found.reference.is_left or far_off(started)
        if not (named or wrong):
            return found
        rest = most - len(described)
        rival = after if named else None
        changes = describe(pool, started, around, seed, rest, progress, rival)
    if named and not changes:
        return found
    first = replace(rounds[0], one_of=())
    found = replace(found, rounds=(first,), described=(*described, *changes))
    return found.only_described()


def _effects(
    pool: ProcessPoolExecutor,
    started: Explained,
    around: Sequence[Surroundings],
    without: Sequence[str],
    seed: int,
    progress: Progress,
) -> tuple[list[Judged], Explained]:
    """Look for effects, one after another; return what was judged and what is explained then."""
    after, channels = started, len(started.observed[0].channels)
    rounds: list[Judged] = []
    for count in range(MOST_ADDED):
        if count and left_over(after, channels) < SETTLED:
            break
        at_first = float(started.unseen.sum())
        judged = _round(pool, after, around, without, at_first, seed, progress)
        rounds.append(judged)
        if not judged.named:
            break
        progress("calibrating the named effect in full")
        grown, around = refined(judged.best)
        share = 1.0 - float(grown.unseen.sum()) / float(after.unseen.sum())
        if out_of_range(grown, share):
            rounds[-1] = replace(judged, one_of=())
            break
        after = grown
        if count:
            progress("asking again which of the first it is")
            rounds[0], after = swapped(rounds[0], after, around)
    if not adequate(started, after, channels):
        rounds, after = [replace(rounds[0], one_of=())], started
    return rounds, after


def _need_excitation(machine: Machine, runs: Sequence[Run]) -> None:
    """Refuse runs in which nothing but the surroundings changes."""
    for entry in machine.inputs:
        if entry.is_boundary:
            continue
        still = entry.low if entry.default is None else entry.default
        most = still + 0.01 * (entry.high - entry.low)
        for run in runs:
            if entry.column in run.frame.columns and run.frame[entry.column].max() > most:
                return
    raise BadInput("--runs", "", "the machine stands still in all of them: nothing can be told")


def _round(
    pool: ProcessPoolExecutor,
    now: Explained,
    around: Sequence[Surroundings],
    without: Sequence[str],
    at_first: float,
    seed: int,
    progress: Progress,
) -> Judged:
    """Look for one more effect."""
    observed = now.observed
    effects = missing_effects(now.machine, without)
    tried: list[Candidate] = []
    jobs = [pool.submit(_candidates, now.machine, observed, effect.name) for effect in effects]
    for effect, job in zip(effects, jobs, strict=True):
        progress(f"screening {effect.name}")
        tried += job.result()
    screen = Screen(Grams.of(now.designs, tried))
    residuals = [design.residual[None] for design in now.designs]
    scores = screen.scores(Data.of(now.designs, tried, residuals, now.pull()))
    gain = scores.unseen[0].sum(axis=0)
    best: dict[str, int] = {}
    for i in np.argsort(-gain):
        best.setdefault(tried[i].key, int(i))
    chosen = list(best.values())[:REFITTED]
    chance = chance_share(screen, now.designs, observed, tried, float(now.unseen.sum()), seed)
    scale, screened = scores.scale[0].tolist(), scores.unseen_cost[0][:, None] - scores.unseen[0]
    refits = [
        pool.submit(
            explain_with, now, tried[i], scale[i], screened[:, i], around, as_tried(tried, tried[i])
        )
        for i in chosen
    ]
    explained = []
    for i, refit in zip(chosen, refits, strict=True):
        progress(f"calibrating with {tried[i].key}")
        explained.append(refit.result())
    return judge(now, explained, chance, len(observed[0].channels), at_first)


def _candidates(machine: Machine, observed: Sequence[Observations], name: str) -> list[Candidate]:
    effect: type[Effect] = next(e for e in missing_effects(machine) if e.name == name)
    return list(candidates(machine, observed, effect))
