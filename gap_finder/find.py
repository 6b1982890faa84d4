"""The gap finder: calibrates, finds what is missing, then judges it on the held-out runs."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from scipy.special import fdtri

from gap_finder.advice import unit_after
from gap_finder.calibrate import ParameterEstimate, Progress, quiet
from gap_finder.comparison import GapComparison
from gap_finder.data_faults import DataFault, without_bad_readings
from gap_finder.design import all_sensitivities
from gap_finder.forward_backward import Hypothesis, Searching, SearchResult, moved_as
from gap_finder.hypotheses import Addition
from gap_finder.keys import effect_of
from gap_finder.observations import Observations, observe
from gap_finder.reference import ReferenceModel
from gap_finder.score import LAW, Fit, scored
from gap_finder.search import USUAL, Search
from gap_finder.standing import calibrated, standing_still
from measurement.errors import BadInput
from measurement.runs import Run
from measurement.workers import one_thread
from measurement.workers import workers as processes
from plant_model.effect_names import name_of
from plant_model.machine import Machine
from plant_model.parameters import FloatArray

FEWEST_RUNS = 3
"""Minimum number of runs, given by leaving each out: with fewer, a single run would remain, which
cannot show what runs have in common."""

ADEQUATE = 1.5
"""Largest error of an adequate model per left-out run and channel [tolerances squared].

Set on the fifth split: with nothing missing 0.9 to 1.2 (three lathes, a jig borer, a belt-driven
spindle)."""

CHANCE = 0.05
"""Probability of doubting a right law by chance [1]: the usual level, set on no split."""

HALVED = 2.0
"""A model lacks something if its gap is this many times that of a regression on the inputs, or, on
the held-out run, that of the worst run used [1]: follows from the question that it answers, and set
on no split."""

ALSO_MISSING = "too much error remains, though no more where it acts than elsewhere"
"""The mildest doubt: of the model more than of the name."""


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
    def stages(self) -> tuple[Hypothesis, ...]:
        """The best, after those before it of which it kept everything, beginning with nothing."""
        stages = [self.search.best]
        for step in reversed(self.search.steps):
            if {*step.baseline.keys} < {*stages[0].keys}:
                stages.insert(0, step.baseline)
        return tuple(stages)

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
        return 1.0 - self.after.cost / self.before.cost


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
    course : tuple of float
        Gap on unseen runs at each of the result's stages [1].
    """

    result: GapResult
    used: GapComparison
    unseen: GapComparison
    reference: ReferenceModel
    course: tuple[float, ...]

    @classmethod
    def of(cls, result: GapResult, unseen: Sequence[Observations]) -> Judged:
        """Judge a result."""
        before, after = result.before.machine, result.after.machine
        used, later = (GapComparison(before, after, runs) for runs in (result.observed, unseen))
        stages = [stage.fit.machine for stage in result.stages]
        between = [GapComparison(before, stage, unseen).gap()["after"] for stage in stages[1:-1]]
        gap = later.gap()
        course = (gap["before"], *between, gap["after"]) if len(stages) > 1 else (gap["after"],)
        return cls(result, used, later, ReferenceModel(after, used.after, later.after), course)

    @property
    def limit(self) -> float:
        """Largest adequate error per left-out run and channel [tolerances squared]."""
        before, after = self.result.before.left_each, self.result.after.left_each
        return max(ADEQUATE, LAW * (before - after))

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
        return self.result.after.left_each <= self.limit and not halved

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
        idle = [key.replace(":", " ") for key in self._idle()]
        if not idle:
            return self._doubt_of_all()
        does = "do" if len(idle) > 1 else "does"
        return f"{' and '.join(idle)} {does} not improve the prediction of the held-out run"

    @property
    def doubted(self) -> tuple[str, ...]:
        """What is named and in doubt: all of it, or only what does not improve the prediction."""
        return self.result.keys if self._doubt_of_all() else self._idle()

    def _doubt_of_all(self) -> str:
        """Return, in words, why all that is named is in doubt together; empty if it is not."""
        if not self.result.keys:
            return ""
        if not is_closed_where_better(self.result.before.left, self.result.after.left):
            return "more error remains where it acts than elsewhere"
        if unusual := unusual_law(self.result.after.calibration.parameters, self.result.keys):
            return unusual
        if not self.is_adequate:
            return ALSO_MISSING
        return ""

    def _idle(self) -> tuple[str, ...]:
        """Return the names that do not improve the prediction of the held-out run."""
        steps = zip(pairwise(self.course), pairwise(self.result.stages), strict=True)
        added = [{*has.keys} - {*had.keys} for (was, now), (had, has) in steps if now >= was]
        return tuple(key for key in self.result.keys if any(key in names for names in added))


def unusual_law(estimates: Iterable[ParameterEstimate], keys: Sequence[str]) -> str:
    """Return, in words, which law cannot have a usual number; empty if all can.

    A stand-in may need an odd delay or exponent. Sizes may be any.

    Parameters
    ----------
    estimates : iterable of ParameterEstimate
        Of the calibrated machine.
    keys : sequence of str
        What was added.
    """
    by_name = {estimate.name: estimate for estimate in estimates}
    for key in keys:
        if (effect := effect_of(key)) is None:
            continue
        for name, usual in effect.parameters.items():
            estimate = by_name.get(f"effects.{key}.{name}")
            if estimate is None or name == effect.amplitude:
                continue
            if estimate.high < usual.low or estimate.low > usual.high:
                return (
                    f"{key.replace(':', ' ')} needs {name} of {estimate.value:.2g}, outside the "
                    f"usual {usual.low:g} to {usual.high:g}{unit_after(usual.unit)}"
                )
    return ""


def is_closed_where_better(before: FloatArray, after: FloatArray) -> bool:
    """Whether the error after is as small where it has improved as elsewhere, or as laws allow.

    A law that only acts like the right one leaves more error where it acts. What the machine's file
    is too coarse for is left everywhere. An F-test compares the two, with each channel of a run
    weighted by how much it has improved there, and by how much less than the most elsewhere. It
    counts as one value, because one misfit lasts for much of a run.

    Parameters
    ----------
    before, after : array, shape (R, C)
        Squared error of each run and channel [tolerances squared].
    """
    better = np.maximum(before - after, 1e-9)
    rest = np.maximum(better.max() - better, 1e-9)
    missing, left = (float(np.average(squares, weights=better)) for squares in (before, after))
    elsewhere = float(np.average(after, weights=rest))
    counts = (weights.sum() ** 2 / np.sum(weights**2) for weights in (better, rest))
    by_chance = float(fdtri(*counts, 1.0 - CHANCE))
    return left <= max(by_chance * elsewhere, LAW * missing)


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
