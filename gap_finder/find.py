"""The gap finder: calibrate, screen what may be missing, refit the best, judge, answer."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

from threadpoolctl import threadpool_limits

from gap_finder.calibrate import Progress, quiet
from gap_finder.data_faults import DataFault
from gap_finder.describe import far_off, select_change
from gap_finder.description import NamedChange
from gap_finder.description_rounds import left_out, select_changes
from gap_finder.design import all_sensitivities
from gap_finder.effect_rounds import select_effects
from gap_finder.keys import laws_of
from gap_finder.observations import Observations
from gap_finder.periods import in_step
from gap_finder.reference import ReferenceModel
from gap_finder.refit import CandidateFit, score_fit
from gap_finder.regimes import residuals
from gap_finder.search import USUAL, Search
from gap_finder.selection import LEAST_SHARE, SelectionRound, above_tolerance
from gap_finder.standing import calibrated
from measurement.errors import BadInput
from measurement.runs import Run
from measurement.workers import workers as processes
from plant_model.machine import Machine

FEWEST_RUNS = 3
"""Runs needed to predict each from the others and still see whether that is chance."""


@dataclass(frozen=True)
class Withdrawal:
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
    def of(cls, best: CandidateFit) -> Withdrawal:
        """Gather from the explanation that added it."""
        key = best.added[-1]
        return cls(key, tuple(one.run.name for one in best.observed if key not in one.absent))


@dataclass(frozen=True)
class GapResult:
    """What the gap finder found.

    Attributes
    ----------
    before, after : CandidateFit
        The calibrated machine as it was given, and with what was added (the same if nothing was).
    rounds : tuple of SelectionRound
        One judgement for each effect asked for.
    withdrawn : tuple of Withdrawal
        Effects that were taken back, because runs never used were worse with them.
    changes : tuple of NamedChange
        What of the description itself was changed: starts of parts, heat paths.
    faults : tuple of DataFault
        What was left out besides, because the calibrated machine says that it is broken.
    """

    before: CandidateFit
    after: CandidateFit
    rounds: tuple[SelectionRound, ...]
    withdrawn: tuple[Withdrawal, ...] = ()
    changes: tuple[NamedChange, ...] = ()
    faults: tuple[DataFault, ...] = ()

    @property
    def observed(self) -> tuple[Observations, ...]:
        """What was compared, with what had not begun yet in each run."""
        return self.after.observed

    @cached_property
    def reference(self) -> ReferenceModel:
        """How well any model with these inputs could do on the runs used, after what was added."""
        machine = self.after.machine
        return ReferenceModel(
            machine, [residuals(machine, in_step(machine, one)) for one in self.observed]
        )

    @property
    def verdict(self) -> str:
        """``effect``, ``one_of``, ``none_missing`` or ``unknown``.

        What does not follow from the inputs in the same way in every run is not reducible, and may
        still be more than a lumped model is wrong by: then something is missing, too.
        """
        first = self.rounds[0]
        if not first.named and not self.changes:
            wrong = first.above_tolerance or self.reference.is_left
            return "unknown" if wrong else "none_missing"
        several = any(len(laws_of(entry.one_of)) > 1 for entry in self.rounds) or any(
            one.or_else for one in self.changes
        )
        return "one_of" if several else "effect"

    @property
    def in_doubt(self) -> bool:
        """Whether something is named, and more than the tolerance is left with it.

        Then something else is missing too, or what is named only acts like it.
        """
        named = self.rounds[0].named or bool(self.changes)
        return named and above_tolerance(self.after)

    def only_described(self) -> GapResult:
        """Return what was found without the effects, the description as it was changed."""
        if not self.changes:
            return replace(self, after=self.before)
        return replace(self, after=self.changes[-1].after)

    def without_change(self, gone: NamedChange) -> GapResult:
        """Return what was found without one change of the description, and without effects.

        Parameters
        ----------
        gone : NamedChange
            One of ``changes``.
        """
        kept = left_out(self.before, self.changes, gone)
        above = self.changes[0].selection.above_tolerance
        first = replace(self.rounds[0], baseline=self.before, one_of=(), above_tolerance=above)
        taken = (*self.withdrawn, Withdrawal(gone.key, ()))
        left = replace(self, rounds=(first,), changes=tuple(kept), withdrawn=taken)
        return left.only_described()

    def with_only(self, count: int) -> GapResult:
        """Return what was found with no more than the first *count* effects that were added.

        Parameters
        ----------
        count : int
            With 0 nothing but the changes of the description is left.
        """
        named = [selection for selection in self.rounds if selection.named]
        if count >= len(named):
            return self
        gone = tuple(Withdrawal.of(selection.best) for selection in named[count:])
        last = self.rounds[count]
        # The second round may have changed which of a set the first is: what it began with counts.
        kept = [
            replace(selection, one_of=tuple(dict.fromkeys((key, *selection.one_of))))
            for selection, key in zip(self.rounds[:count], last.baseline.added, strict=True)
        ]
        rounds = (*kept, replace(last, one_of=()))
        return replace(self, after=last.baseline, rounds=rounds, withdrawn=gone)


def find_gap(
    machine: Machine,
    runs: Sequence[Run],
    search: Search = USUAL,
    *,
    progress: Progress = quiet,
) -> GapResult:
    """Find what is missing in a machine's model.

    Parameters
    ----------
    machine : Machine
    runs : sequence of Run
        At least three, of different speeds; their order does not matter.
    search : Search
        How to look for it.
    progress : callable
        Told what is being done.

    Raises
    ------
    BadInput
        When there are too few runs, or nothing in them excites the machine.
    """
    with threadpool_limits(1):
        return _find(machine, runs, search, progress)


def _find(machine: Machine, runs: Sequence[Run], search: Search, progress: Progress) -> GapResult:
    if len(runs) < FEWEST_RUNS:
        raise BadInput(
            "--runs", "", f"{len(runs)} given; {FEWEST_RUNS} or more are needed to name an effect"
        )
    ordered = sorted(runs, key=lambda run: run.name)
    _need_excitation(machine, ordered)
    calibration, observed, faults = calibrated(
        machine, ordered, seed=search.seed, progress=progress
    )
    progress("what else may be wrong")
    sensitivities = all_sensitivities(machine, calibration.machine, observed)
    before = score_fit(machine, (), observed, calibration, sensitivities)
    with processes(search.workers) as pool:
        progress("what starts at another temperature")
        restarted, started = select_change(
            pool,
            before,
            sensitivities,
            search.seed,
            only=("start_state",),
            least=LEAST_SHARE,
            locally=False,
        )
        changes = [restarted] if restarted else []
        rounds, after = select_effects(pool, started, sensitivities, search, progress)
        found = GapResult(before, after, tuple(rounds), (), tuple(changes), tuple(faults))
        named = rounds[0].named
        # Not by the verdict: with another start of a part, that is an answer already.
        wrong = rounds[0].above_tolerance or found.reference.is_left or far_off(started)
        if not (named or wrong):
            return found
        rest = search.most - len(changes)
        rival = after if named else None
        further = select_changes(pool, started, sensitivities, search.seed, rest, progress, rival)
    if named and not further:
        return found
    first = replace(rounds[0], one_of=())
    found = replace(found, rounds=(first,), changes=(*changes, *further))
    return found.only_described()


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
