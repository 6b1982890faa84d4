"""The gap finder: calibrate, look for what is missing, answer; then open the held-out run."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from threadpoolctl import threadpool_limits

from gap_finder.calibrate import Progress, quiet
from gap_finder.comparison import GapComparison
from gap_finder.data_faults import DataFault, without_bad_readings
from gap_finder.design import all_sensitivities
from gap_finder.forward_backward import LAW, Searching, SearchResult
from gap_finder.observations import Observations, observe
from gap_finder.reference import ReferenceModel
from gap_finder.score import Fit, scored
from gap_finder.search import USUAL, Search
from gap_finder.standing import calibrated, standing_still
from measurement.errors import BadInput
from measurement.runs import Run
from measurement.workers import workers as processes
from plant_model.effect_names import name_of
from plant_model.machine import Machine
from plant_model.parameters import FloatArray

FEWEST_RUNS = 3
"""Runs needed, given by leaving each out: of fewer, the rest would be one run, of which nothing
tells what it has in common with others."""

ADEQUATE = 1.5
"""What a model may leave per run and channel, predicted from the other runs [tolerances squared].

Set on the fifth split: with nothing missing 0.9 to 1.2 (three lathes, a jig borer, a belt-driven
spindle)."""

HALVED = 2.0
"""Times what a regression on the inputs leaves from which a model lacks something [1]: by the
question that it answers, and set on no split."""


@dataclass(frozen=True)
class GapResult:
    """What the gap finder found.

    Attributes
    ----------
    search : SearchResult
        The hypotheses.
    faults : tuple of DataFault
        What was left out besides, because the calibrated machine says that it is broken.
    """

    search: SearchResult
    faults: tuple[DataFault, ...] = ()

    @property
    def before(self) -> Fit:
        """The calibrated machine as it was given."""
        return self.search.nothing.fit

    @property
    def after(self) -> Fit:
        """The same with what was added; *before* itself if nothing was."""
        return self.search.best.fit

    @property
    def keys(self) -> tuple[str, ...]:
        """What was added."""
        return self.search.best.keys

    @property
    def observed(self) -> tuple[Observations, ...]:
        """What was compared, with what had not begun yet in each run."""
        return self.after.observed

    @property
    def explained(self) -> float:
        """Share of what was left of runs predicted from the others that all names explain [1]."""
        return 1.0 - self.after.cost / self.before.cost


@dataclass(frozen=True)
class Judged:
    """What is found, held against runs never used; everything that is said follows from it.

    Attributes
    ----------
    result : GapResult
    used, unseen : GapComparison
        On the runs used, and on those never used.
    reference : ReferenceModel
        How well any model with these inputs could do.
    """

    result: GapResult
    used: GapComparison
    unseen: GapComparison
    reference: ReferenceModel

    @classmethod
    def of(cls, result: GapResult, unseen: Sequence[Observations]) -> Judged:
        """Judge what was found."""
        before, after = result.before.machine, result.after.machine
        used, later = (GapComparison(before, after, runs) for runs in (result.observed, unseen))
        return cls(result, used, later, ReferenceModel(after, used.after, later.after))

    @property
    def is_adequate(self) -> bool:
        """Whether so little is left that nothing else need be missing."""
        rows = (
            self.used.gap_against(self.reference.used),
            self.unseen.gap_against(self.reference.unseen),
        )
        halved = any(row["after"] > HALVED * row["reference"] for row in rows)
        return self.result.after.left_each <= ADEQUATE and not halved

    @property
    def verdict(self) -> str:
        """``effect``, ``one_of``, ``none_missing`` or ``unknown``."""
        if not self.result.keys:
            return "none_missing" if self.is_adequate else "unknown"
        several = any(
            name_of(rival.keys[-1]) != name_of(key)
            for key, rivals in zip(self.result.keys, self.result.search.rivals, strict=True)
            for rival in rivals
        )
        return "one_of" if several else "effect"

    @property
    def in_doubt(self) -> bool:
        """Whether something is named, and too much is left with it, or unseen runs gain nothing.

        Then something else is missing too, or what is named only acts like it.
        """
        before, after = self.result.before.left, self.result.after.left
        gap = self.unseen.gap()
        gained = gap["after"] < gap["before"]
        sound = self.is_adequate and is_closed_where_better(before, after) and gained
        return bool(self.result.keys) and not sound


def is_closed_where_better(before: FloatArray, after: FloatArray) -> bool:
    """Whether no more is left than a right law may leave, where less is left than before.

    A channel of a run counts by what it is better by: a law that only acts like the right one
    leaves the more where it acts, and nothing elsewhere.

    Parameters
    ----------
    before, after : array, shape (R, C)
        Squares that are left of each run and channel [tolerances squared].
    """
    better = np.maximum(before - after, 1e-9)
    missing, left = (float(np.average(squares, weights=better)) for squares in (before, after))
    return left <= max(ADEQUATE, LAW * missing)


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
    if len(runs) < FEWEST_RUNS:
        raise BadInput(
            "--runs", "", f"{len(runs)} given; {FEWEST_RUNS} or more are needed to name an effect"
        )
    ordered = sorted(runs, key=lambda run: run.name)
    _need_excitation(machine, ordered)
    with threadpool_limits(1):
        calibration, observed, faults = calibrated(
            machine, ordered, seed=search.seed, progress=progress
        )
        with processes(search.workers) as pool:
            sensitivities = all_sensitivities(calibration.machine, observed, pool)
            nothing = scored(machine, observed, calibration, sensitivities)
            found = Searching(pool, nothing, search, progress).run(sensitivities)
    return GapResult(found, tuple(faults))


def answer(
    machine: Machine,
    runs: Sequence[Run],
    unseen: Sequence[Run],
    search: Search = USUAL,
    *,
    progress: Progress = quiet,
) -> tuple[Judged, list[DataFault]]:
    """Find what is missing in a machine's model, and hold it against runs never used.

    Parameters
    ----------
    machine : Machine
    runs, unseen : sequence of Run
        Without what is broken by the data alone.
    search, progress
        As in `find_gap`.

    Returns
    -------
    judged : Judged
    faults : list of DataFault
        Thermometers that stand still while the calibrated machine moves; left out.
    """
    result = find_gap(machine, runs, search, progress=progress)
    progress("judging by what was kept back")
    channels = result.observed[0].channels
    later = observe(machine, unseen, channels=channels)
    names = {run.name for run in unseen}
    still = [
        fault
        for fault in standing_still(result.before.machine, [*result.observed, *later])
        if fault.run in names
    ]
    if still:
        sound = [without_bad_readings(machine, run, still) for run in unseen]
        later = observe(machine, sound, channels=channels)
    return Judged.of(result, later), [*result.faults, *still]


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
