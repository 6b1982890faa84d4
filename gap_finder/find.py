"""The gap finder: calibrates, finds what is missing, then judges it on the held-out runs."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from gap_finder.calibrate import Progress, quiet
from gap_finder.comparison import GapComparison
from gap_finder.data_faults import DataFault, without_bad_readings
from gap_finder.design import all_sensitivities
from gap_finder.forward_backward import Searching, SearchResult, moved_as
from gap_finder.hypotheses import Addition
from gap_finder.observations import Observations, observe
from gap_finder.reference import ReferenceModel
from gap_finder.score import Fit, scored
from gap_finder.search import USUAL, Search
from gap_finder.standing import calibrated, standing_still
from measurement.errors import BadInput
from measurement.runs import Run
from measurement.workers import one_thread
from measurement.workers import workers as processes
from plant_model.effect_names import name_of
from plant_model.machine import Machine

FEWEST_RUNS = 3
"""Minimum number of runs, given by leaving each out: with fewer, a single run would remain, which
cannot show what runs have in common."""

ADEQUATE = 1.5
"""Largest error of an adequate model per left-out run and channel [tolerances squared].

Set on the fifth split: with nothing missing 0.9 to 1.2 (three lathes, a jig borer, a belt-driven
spindle)."""

HALVED = 2.0
"""A model lacks something if its gap is this many times that of a regression on the inputs, or, on
the held-out run, that of the worst run used [1]: follows from the question that it answers, and set
on no split."""


@dataclass(frozen=True)
class GapResult:
    """What the gap finder found.

    Attributes
    ----------
    search : SearchResult
        The hypotheses.
    faults : tuple of DataFault
        Further data left out because the calibrated machine shows that they are broken.
    """

    search: SearchResult
    faults: tuple[DataFault, ...] = ()

    @property
    def before(self) -> Fit:
        """The given machine, calibrated."""
        return self.search.nothing.fit

    @property
    def after(self) -> Fit:
        """The calibrated machine with all additions; *before* itself if there are none."""
        return self.search.best.fit

    @property
    def keys(self) -> tuple[str, ...]:
        """What was added."""
        return self.search.best.keys

    @property
    def observed(self) -> tuple[Observations, ...]:
        """What was compared, including which effects had not begun yet in each run."""
        return self.after.observed

    def without(self, addition: Addition) -> Machine:
        """Return the calibrated machine with everything that was added but one.

        Raises
        ------
        KeyError
            If another one is at a part that this one brought.
        """
        machine = self.before.base
        for other in self.search.best.additions:
            if other is not addition:
                machine = other.put_into(machine)
        return moved_as(machine, self.after.machine)

    @property
    def explained(self) -> float:
        """Share of the squared error of left-out runs that all additions explain [1]."""
        return self.search.explained(self.search.best)


@dataclass(frozen=True)
class Judged:
    """A result, judged on unseen runs; the whole report follows from it.

    Attributes
    ----------
    result : GapResult
    used, unseen : GapComparison
        On the runs used, and on unseen runs.
    reference : ReferenceModel
        How well any model with these inputs could do.
    """

    result: GapResult
    used: GapComparison
    unseen: GapComparison
    reference: ReferenceModel

    @classmethod
    def of(cls, result: GapResult, unseen: Sequence[Observations]) -> Judged:
        """Judge a result."""
        before, after = result.before.machine, result.after.machine
        used, later = (GapComparison(before, after, runs) for runs in (result.observed, unseen))
        return cls(result, used, later, ReferenceModel(after, used.after, later.after))

    @property
    def is_adequate(self) -> bool:
        """Whether the remaining error is so small that nothing else need be missing."""
        used = self.used.gap_against(self.reference.used)
        unseen = self.unseen.gap_against(self.reference.unseen)
        pairs = (
            (used["reference"], used),
            (unseen["reference"], unseen),
            (self.used.worst(), unseen),
        )
        halved = any(row["after"] > HALVED * least for least, row in pairs)
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
    def doubt(self) -> str:
        """Why what is named is in doubt, in words; empty if it is not, or nothing is named.

        In doubt, something else is also missing, or what is named only acts like it.
        """
        if not self.result.keys:
            return ""
        if not self.is_adequate:
            return "too much error remains"
        gap = self.used.gap_against(self.reference.used)
        if gap["before"] - gap["reference"] > HALVED * (gap["before"] - gap["after"]):
            return "a regression on the inputs closes more than twice as much of the gap"
        return ""


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
        At least three, of different speeds, in any order.
    search : Search
        Options of the search.
    progress : callable
        Called with each step in words.

    Raises
    ------
    BadInput
        If there are too few runs, or nothing in them excites the machine.
    """
    if len(runs) < FEWEST_RUNS:
        raise BadInput(
            "--runs", "", f"{len(runs)} given; {FEWEST_RUNS} or more are needed to name an effect"
        )
    ordered = sorted(runs, key=lambda run: run.name)
    _need_excitation(machine, ordered)
    with one_thread():
        calibration, observed, faults = calibrated(
            machine, ordered, seed=search.seed, progress=progress
        )
        with processes(search.workers) as pool:
            sensitivities = all_sensitivities(calibration.machine, observed, pool)
            nothing = scored(machine, observed, calibration, sensitivities)
            searched = Searching(pool, nothing, search, progress).run(sensitivities)
    return GapResult(searched, tuple(faults))


def answer(
    machine: Machine,
    runs: Sequence[Run],
    unseen: Sequence[Run],
    search: Search = USUAL,
    *,
    progress: Progress = quiet,
) -> tuple[Judged, list[DataFault]]:
    """Find what is missing in a machine's model, and judge it on unseen runs.

    Parameters
    ----------
    machine : Machine
    runs, unseen : sequence of Run
        Without readings that the data alone show to be broken.
    search, progress
        As in `find_gap`.

    Returns
    -------
    judged : Judged
    faults : list of DataFault
        Thermometers that stand still while the calibrated model moves; left out.
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
    """Refuse runs in which only the surroundings change."""
    for entry in machine.inputs:
        if entry.is_boundary:
            continue
        still = entry.low if entry.default is None else entry.default
        most = still + 0.01 * (entry.high - entry.low)
        for run in runs:
            if entry.column in run.frame.columns and run.frame[entry.column].max() > most:
                return
    raise BadInput("--runs", "", "the machine stands still in all of them: nothing can be told")
