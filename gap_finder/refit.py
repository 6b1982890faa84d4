"""Fits of candidates: calibrated anew with an effect in force, scored leaving one run out."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from gap_finder.calibrate import Calibration, calibrate, intervals
from gap_finder.candidates import (
    Candidate,
    beyond_usual_range,
    given_values,
    widened,
    with_effect,
)
from gap_finder.design import RunDesign, RunSensitivities, all_sensitivities, design_of
from gap_finder.keys import is_switched
from gap_finder.observations import Observations
from gap_finder.priors import Priors
from gap_finder.screen import NormalMatrices, ResidualSets, Screen
from plant_model.effects import catalogue
from plant_model.integrate import IntegrationError
from plant_model.machine import Machine
from plant_model.parameters import FloatArray

LARGER = (1.2, 2.5, 6.0)
"""Times the end of the usual range at which an amplitude beyond it is started from [1]."""

REFITS = 4
"""Iterations of a calibration that starts from a calibrated machine."""


@dataclass(frozen=True)
class CandidateFit:
    """A candidate: a machine with some effects added, calibrated and scored.

    Attributes
    ----------
    added : tuple of str
        Keys of the effects.
    base : Machine
        With the effects in force, before calibration: its values are the prior's centre.
    calibration : Calibration
    designs : tuple of RunDesign
        About the calibrated machine.
    observed : tuple of Observations
        With what had not begun yet in each run.
    cost : float
        Weighted squares that recalibration of all nuisance parameters leaves.
    loro_cost : array, shape (R,)
        Leave-one-run-out cost: the same in each run, predicted from the others.
    acts : tuple of bool
        Whether the effect added last does anything in each run; empty if none was.
    """

    added: tuple[str, ...]
    base: Machine
    calibration: Calibration
    designs: tuple[RunDesign, ...]
    observed: tuple[Observations, ...]
    cost: float
    loro_cost: FloatArray
    acts: tuple[bool, ...] = ()

    @property
    def machine(self) -> Machine:
        """The calibrated machine."""
        return self.calibration.machine

    @property
    def at_bounds(self) -> tuple[str, ...]:
        """Parameters of the effect added last that calibration takes to their bounds.

        Its amplitude, and what else makes its law; empty if all of them lie inside. An amplitude's
        range is the usual one at first, and the possible one in :func:`refit_beyond_usual`.
        """
        if not self._of_catalogue:
            return ()
        if is_switched(self.machine, self.added[-1]):
            return ()  # Coolant that stands altogether is no other law.
        effect = catalogue()[self.added[-1].partition(":")[0]]
        telling = {f"effects.{self.added[-1]}.{name}" for name in (effect.amplitude, *effect.law)}
        return tuple(
            one.name.rpartition(".")[2]
            for one in self.calibration.parameters
            if one.at_bound and one.name in telling
        )

    @property
    def beyond_usual(self) -> tuple[str, ...]:
        """Parameters of the effect added last that lie outside what is usual."""
        return beyond_usual_range(self.machine, self.added[-1]) if self._of_catalogue else ()

    @property
    def is_ordinary(self) -> bool:
        """Whether the effect added last is so small that any machine has as much."""
        if not self._of_catalogue:
            return False
        effect = catalogue()[self.added[-1].partition(":")[0]]
        value = self.machine.effects[self.added[-1]][effect.amplitude].value
        return abs(value - effect.off) < effect.least

    @property
    def _of_catalogue(self) -> bool:
        """Whether what was added last is an effect, and not another start of a part."""
        return bool(self.added) and self.added[-1].partition(":")[0] in catalogue()

    @property
    def pieces(self) -> int:
        """Pieces of evidence: every channel of every run."""
        return len(self.loro_cost) * len(self.observed[0].channels)

    def position(self) -> FloatArray:
        """Return where calibration left its parameters, in the fitting scale, shape (P,)."""
        return Priors.of(self.base, calibrated=True).position(self.machine)


def fit_effects(
    base: Machine,
    added: Sequence[str],
    observed: Sequence[Observations],
    start_from: Sequence[Machine],
    sensitivities: Sequence[RunSensitivities],
) -> CandidateFit:
    """Calibrate a machine with effects added, and score it run by run."""
    calibration = calibrate(
        base,
        observed,
        starts=1,
        iterations=REFITS,
        start_from=start_from,
        sensitivities=sensitivities,
    )
    return score_fit(base, added, observed, calibration, sensitivities)


def score_fit(
    base: Machine,
    added: Sequence[str],
    observed: Sequence[Observations],
    calibration: Calibration,
    sensitivities: Sequence[RunSensitivities],
) -> CandidateFit:
    """Score a calibrated machine run by run."""
    moved = Priors.of(base, calibrated=True)
    designs = design_of(calibration.machine, observed, moved, sensitivities)
    grams = NormalMatrices.of(designs, ())
    screen = Screen(grams)
    residuals = [design.residual[None] for design in designs]
    scores = screen.scores(
        ResidualSets.of(designs, (), residuals, moved.position(calibration.machine))
    )
    # What calibration does not move makes what it moves less certain.
    covariance = np.linalg.inv(grams.shared.sum(axis=0) + np.eye(grams.shared.shape[1]))
    spread = np.sqrt(np.diag(covariance))[: len(moved.names)]
    for design in designs:
        spread[list(design.alone)] = design.deviations_alone(covariance)
    # Where more is left than the tolerance explains, what the runs say is less certain by as much.
    pieces = len(observed) * len(observed[0].channels)
    spread = np.minimum(spread * np.sqrt(max(1.0, float(scores.cost[0]) / pieces)), 1.0)
    told = intervals(base, moved, moved.position(calibration.machine), spread)
    return CandidateFit(
        tuple(added),
        base,
        replace(calibration, parameters=told),
        tuple(designs),
        tuple(observed),
        float(scores.cost[0]),
        np.asarray(scores.loro_cost[0]),
    )


def fit_candidate(
    before: CandidateFit,
    candidate: Candidate,
    scale: float,
    screened: FloatArray,
    sensitivities: Sequence[RunSensitivities],
    sizes: Sequence[Candidate] = (),
) -> CandidateFit:
    """Add a candidate to what is explained so far and calibrate everything anew.

    Parameters
    ----------
    before : CandidateFit
    candidate : Candidate
    scale : float
        What the screening multiplied its answer by. Where the effect is far from linear, its
        amplitude as it was tried may be the better point to start from.
    screened : array, shape (R,)
        What the screening leaves of every run predicted from the others. That and the calibrated
        machine's own are predictions of runs not seen, so the better one counts: about the
        calibrated point an effect that is far from linear answers to other values in a way that
        its derivatives do not know.
    sensitivities : sequence of RunSensitivities
    sizes : sequence of Candidate
        Further points to start from, each for itself, for an effect so far from linear that
        everything else must have moved before it does any good.
    """
    observed = [candidate.seen_by(i, one) for i, one in enumerate(before.observed)]
    given = given_values(candidate.key, candidate.values)
    base = with_effect(before.base, candidate.key, given)
    points = [[candidate.scaled(scale), candidate.values], *([one.values] for one in sizes)]
    found = min(
        (
            fit_effects(
                base,
                (*before.added, candidate.key),
                observed,
                [with_effect(before.machine, candidate.key, values) for values in point],
                sensitivities,
            )
            for point in points
        ),
        key=lambda one: one.calibration.cost,
    )
    loro_cost = min(found.loro_cost, screened, key=np.sum)
    found = replace(found, loro_cost=loro_cost, acts=candidate.acts)
    return refit_beyond_usual(found, sensitivities) if found.at_bounds else found


def refit_beyond_usual(
    found: CandidateFit, sensitivities: Sequence[RunSensitivities]
) -> CandidateFit:
    """Calibrate anew what ends at an end of its range, its amplitude bounded by physics alone.

    A range says what is usual. What fits better beyond it is larger than usual; what does not is
    something else, and stays as it was found.
    """
    key = found.added[-1]
    effect = catalogue()[key.partition(":")[0]]
    base, start = widened(found.base, key), widened(found.machine, key)
    name = f"effects.{key}.{effect.amplitude}"
    now, free = start.parameters[name].value, base.parameters[name]
    if effect.amplitude not in found.at_bounds or not free.low < now < free.high:
        return found
    sizes = [effect.off + times * (now - effect.off) for times in LARGER]
    points = [start.with_values({name: float(np.clip(v, free.low, free.high))}) for v in sizes]
    try:
        wider = fit_effects(base, found.added, found.observed, points, sensitivities)
        if wider.beyond_usual and wider.calibration.cost < found.calibration.cost:
            # The derivatives so far are those of the machine without it, whose other numbers gave
            # way to it: they say nothing of how well runs are predicted with so much of it.
            wider, _ = refit_in_full(wider)
    except IntegrationError:
        return found
    better = float(wider.loro_cost.sum()) < float(found.loro_cost.sum())
    return replace(wider, acts=found.acts) if better and wider.beyond_usual else found


def refit_in_full(
    best: CandidateFit, also: Sequence[Machine] = ()
) -> tuple[CandidateFit, list[RunSensitivities]]:
    """Calibrate a candidate with derivatives of its own, and score it anew.

    Screening borrows the derivatives of the machine without the effect, which is enough to compare;
    a strong effect changes them. *also* holds further machines to start from.
    """
    observed = best.observed
    calibration = min(
        (
            calibrate(best.base, observed, starts=1, start_from=[one])
            for one in (best.machine, *also)
        ),
        key=lambda one: one.cost,
    )
    sensitivities = all_sensitivities(best.base, calibration.machine, observed)
    found = score_fit(best.base, best.added, observed, calibration, sensitivities)
    return replace(found, loro_cost=min(found.loro_cost, best.loro_cost, key=np.sum)), sensitivities
