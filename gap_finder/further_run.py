"""Which further run would tell explanations apart: simulated with each, its evidence weighed."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
import pandas as pd

from gap_finder.design import RunDesign, run_design, sensitivities_of
from gap_finder.observations import Observations, observe
from gap_finder.priors import Priors
from gap_finder.refit import CandidateFit
from gap_finder.regimes import noise_of
from gap_finder.screen import NormalMatrices
from gap_finder.selection import RIVAL_ODDS, cost_unit
from measurement.runs import Run
from plant_model.machine import Input, Machine
from plant_model.parameters import FloatArray
from plant_model.sensors import displacement_names
from plant_model.simulate import simulate

HOURS = 6.0
EVERY_S = 60.0

PROFILES: dict[str, tuple[tuple[float, float], ...]] = {
    "6 h at the highest {what}": ((0.0, 1.0),),
    "3 h at the highest {what}, then 3 h without": ((0.0, 1.0), (3.0, 0.0)),
    "3 h at a third of the highest {what}, then 3 h at the highest": ((0.0, 0.33), (3.0, 1.0)),
    "half an hour on and half an hour off at the highest {what}": tuple(
        (0.5 * i, 1.0 - i % 2) for i in range(12)
    ),
    "{what} rising by a sixth of the highest every hour": tuple(
        (float(i), (i + 1) / 6.0) for i in range(6)
    ),
    "6 h at a quarter of the highest {what}": ((0.0, 0.25),),
    "2 h each at the highest, a third and two thirds of the highest {what}": (
        (0.0, 1.0),
        (2.0, 0.33),
        (4.0, 0.67),
    ),
}
"""Runs to choose from: hours at which the share of the highest value seen so far changes."""

WORDS = {"rpm": "speed", "mm_min": "feed"}
"""What a control can be told to do, by the unit of the input."""

WEIGHED = 6
"""Profiles whose evidence is weighed, those whose readings would differ most first."""

Stretches = tuple[tuple[float, float], ...]
"""Seconds at which an input changes, and its values."""

TELLING = 2.0
"""Differences below so many times a sensor's noise tell nothing [1]."""


@dataclass(frozen=True)
class FurtherRun:
    """A run that would tell explanations apart.

    Attributes
    ----------
    profile : str
        What is done, in words.
    stretches : dict of str to tuple of (float, float)
        For each driving input: seconds at which its value changes, and the values.
    held : dict of str to float
        Boundary temperatures that were assumed [degC].
    channel : str
        Where readings would differ most.
    difference, unit : float, str
        By how much.
    evidence : float
        By how much the cost of the wrong one would rise, everything else calibrated anew: twice the
        logarithm of the odds against it, for the rival that is told apart worst. In units of what
        the best one leaves, in which the answer is judged, too.
    """

    profile: str
    stretches: dict[str, Stretches]
    held: dict[str, float]
    channel: str
    difference: float
    unit: str
    evidence: float

    def said(self) -> str:
        """Return it as a sentence."""
        odds = float(np.exp(min(0.5 * self.evidence, 50.0)))
        about = f"{float(f'{odds:.2g}'):g}" if odds < 1e3 else "more than 1,000"
        told = f"would differ by up to {self.difference:.2g} {self.unit}, odds of {about} to 1"
        enough = "" if 1.0 / odds < RIVAL_ODDS else ", too little to tell them apart for sure"
        return f"{self.profile}: {self.channel} {told}{enough}"


def further_run(
    fits: Sequence[CandidateFit], observed: Sequence[Observations]
) -> FurtherRun | None:
    """Return the run that tells explanations apart best, or None if none of those tried does.

    Parameters
    ----------
    fits : sequence of CandidateFit
        The best one first; it is held against each of the others.
    observed : sequence of Observations
        Of the runs that there are.

    Notes
    -----
    The rival's readings are predicted by the best fit, whose parameters may move as far as the runs
    that there are leave open; what is left is the expected evidence against it. A model that is
    wrong by more than its tolerance will be no surer of the next run.
    """
    best, rivals = fits[0], fits[1:]
    names = observed[0].channels
    noise = noise_of(best.machine, names)
    plans = []
    for profile, stretches in _profiles(best.machine, observed):
        inputs = _inputs(best.machine, stretches, observed)
        ours = _channels(best.machine, inputs, names)
        apart = [np.abs(_channels(one.machine, inputs, names) - ours).max(axis=0) for one in rivals]
        least = np.min([np.max(one / noise) for one in apart])
        if least >= TELLING:
            plans.append((float(least), profile, stretches, inputs, np.min(apart, axis=0)))
    plans.sort(key=lambda plan: -plan[0])
    lengths = displacement_names(best.machine)
    found = None
    known = _told_so_far(best) if plans else np.zeros((0, 0))
    unit = cost_unit(float(best.loro_cost.sum()), best.pieces)
    for _, profile, stretches, inputs, difference in plans[:WEIGHED]:
        evidence = min(_evidence(best, one.machine, inputs, names, known) for one in rivals) / unit
        if found is None or evidence > found.evidence:
            i = int(np.argmax(difference / noise))
            shown_in = "um" if names[i] in lengths else "K"
            held = {
                entry.name: float(inputs[entry.name].iloc[0])
                for entry in best.machine.inputs
                if entry.is_boundary and entry.name in inputs
            }
            found = FurtherRun(
                profile, stretches, held, names[i], float(difference[i]), shown_in, evidence
            )
    return found


def _profiles(
    machine: Machine, observed: Sequence[Observations]
) -> Iterator[tuple[str, dict[str, Stretches]]]:
    """Yield every profile with all driving inputs together and, if there are several, with each."""
    driving = [
        (entry, most)
        for entry in machine.inputs
        if entry.unit in WORDS and (most := _most(entry, observed)) > 0.0
    ]
    groups = [driving, *([one] for one in driving if len(driving) > 1)]
    for group in groups:
        what = " and ".join(WORDS[entry.unit] for entry, _ in group)
        rest = "".join(f", no {WORDS[one[0].unit]}" for one in driving if one not in group)
        for profile, changes in PROFILES.items():
            stretches: dict[str, Stretches] = {entry.name: ((0.0, 0.0),) for entry, _ in driving}
            for entry, most in group:
                stretches[entry.name] = tuple(
                    (3600.0 * hour, round(share * most, 1)) for hour, share in changes
                )
            yield profile.format(what=what) + rest, stretches


def _most(entry: Input, observed: Sequence[Observations]) -> float:
    """Return the highest value of an input in any run; 0 if no run has it."""
    seen = [one.run.frame[entry.column] for one in observed if entry.column in one.run.frame]
    return max((float(np.nanmax(part)) for part in seen), default=0.0)


def _inputs(
    machine: Machine,
    stretches: dict[str, Stretches],
    observed: Sequence[Observations],
) -> pd.DataFrame:
    time = np.arange(0.0, HOURS * 3600.0 + 30.0, EVERY_S)
    columns = {"time_s": time}
    for entry in machine.inputs:
        if entry.name in stretches:
            starts, values = zip(*stretches[entry.name], strict=True)
            at = np.searchsorted(starts, time, side="right") - 1
            columns[entry.name] = np.array(values)[at]
        elif entry.is_boundary:
            seen = [
                one.run.frame[entry.column] for one in observed if entry.column in one.run.frame
            ]
            if seen:
                mean = float(np.nanmean(np.concatenate(seen)))
                columns[entry.name] = np.full(len(time), round(mean, 1))
    return pd.DataFrame(columns)


def _channels(machine: Machine, inputs: pd.DataFrame, names: tuple[str, ...]) -> FloatArray:
    shown = simulate(machine, inputs, step_s=EVERY_S, tolerance=1e-2).readings
    return np.stack([shown[name][0] for name in names], axis=-1)


def _told_so_far(best: CandidateFit) -> FloatArray:
    """Return the normal matrix of the runs that there are, shape (Q, Q).

    About the best fit, and column by column: those directions that move nothing in the runs so far
    may well move something in the next.
    """
    designs = [_design(best, one) for one in best.observed]
    return np.asarray(NormalMatrices.of(designs, ()).shared.sum(axis=0))


def _design(best: CandidateFit, one: Observations) -> RunDesign:
    """Return the design of a run about the best fit, column by column."""
    moved = Priors.of(best.base, calibrated=True)
    fixed = Priors.of(best.machine, calibrated=False)
    about = sensitivities_of(best.machine, one, moved, fixed)
    return run_design(best.machine, one, moved, about)


def _evidence(
    best: CandidateFit,
    rival: Machine,
    inputs: pd.DataFrame,
    names: tuple[str, ...],
    known: FloatArray,
) -> float:
    """Return the cost that the rival's run leaves to the best fit, calibrated on all runs."""
    frame = simulate(rival, inputs, step_s=EVERY_S, tolerance=1e-2).run_frame()
    (one,) = observe(best.machine, [Run("further_run", frame)], channels=names)
    design = _design(best, one)
    clean = design.cleaned(design.residual)
    against = design.shared.T @ clean
    matrix = known + design.shared.T @ design.cleaned(design.shared) + np.eye(len(known))
    return float(design.residual @ clean - against @ np.linalg.solve(matrix, against))
