"""The score of a hypothesis: how well it predicts runs left out, and how many there are like it.

One fit for every hypothesis, "nothing" included: calibrated on all runs, then in each fold anew on
all runs but one, which is simulated with the numbers of its fold.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from gap_finder.calibrate import Calibration, calibrate, intervals
from gap_finder.design import RunDesign, RunSensitivities, design_of
from gap_finder.linearise import residuals_of
from gap_finder.observations import Observations
from gap_finder.priors import FAR, Priors
from plant_model.machine import Machine
from plant_model.parameters import FloatArray

REFITS = 8
"""Iterations of a calibration that starts from a calibrated machine; set for time, on no data."""

FIRST = 2
"""Iterations after which a calibration must be worth going on with, where that is asked; set for
time, on no data."""

FOLD_STEPS = 3
"""Steps of the recalibration in each fold, every one simulated; set for time, on no data."""

SHORTER = 0.25
"""Share of a step that is tried after one that does not help [1]; set on no data."""


@dataclass(frozen=True)
class Fit:
    """A machine, calibrated and scored run by run.

    Attributes
    ----------
    base : Machine
        Before calibration: its values are the prior's centre.
    calibration : Calibration
    observed : tuple of Observations
    left : array, shape (R, C)
        Squares that are left of each run and channel, predicted from the other runs [tolerances
        squared, each channel of a run as many as it has independent values].
    other_position : array, shape (Q - P,)
        Where the unknowns that calibration does not move lie at the calibrated point [deviations].
    """

    base: Machine
    calibration: Calibration
    observed: tuple[Observations, ...]
    left: FloatArray
    other_position: FloatArray

    @property
    def machine(self) -> Machine:
        """The calibrated machine."""
        return self.calibration.machine

    @property
    def cost(self) -> float:
        """What is left of all runs, each predicted from the others."""
        return float(self.left.sum())

    @property
    def moved_cost(self) -> float:
        """-2 log of how likely all unknowns are, where they end, by their prior."""
        x = np.append(self.position(), self.other_position)
        return float(x @ x)

    @property
    def left_each(self) -> float:
        """What is left per run and channel [tolerances squared]."""
        return self.cost / self.left.size

    def position(self) -> FloatArray:
        """Return where calibration left its parameters, in the fitting scale, shape (P,)."""
        return Priors.of(self.base, calibrated=True).position(self.machine)


def fit(
    base: Machine,
    observed: Sequence[Observations],
    start_from: Sequence[Machine],
    sensitivities: Sequence[RunSensitivities],
    cost_limit: float = np.inf,
) -> Fit | None:
    """Calibrate a machine on all runs, and score it.

    Parameters
    ----------
    base : Machine
        Its values are the prior's centre.
    observed : sequence of Observations
    start_from : sequence of Machine
        Each is started from, and the best kept.
    sensitivities : sequence of RunSensitivities
        Of a machine near it: how what only one run has, and what calibration does not move, acts.
    cost_limit : float
        None is returned if the cost is not below this after a few iterations.
    """
    calibrated = partial(calibrate, base, observed, starts=1, sensitivities=sensitivities)
    begun = None
    if cost_limit < np.inf:
        begun = calibrated(iterations=FIRST, start_from=start_from)
        if begun.cost > cost_limit:
            return None
    calibration = calibrated(iterations=REFITS, start_from=start_from, go_on=begun)
    return scored(base, observed, calibration, sensitivities)


def scored(
    base: Machine,
    observed: Sequence[Observations],
    calibration: Calibration,
    sensitivities: Sequence[RunSensitivities],
) -> Fit:
    """Score a calibrated machine run by run."""
    moved = Priors.of(base, calibrated=True)
    x = moved.position(calibration.machine)
    designs = design_of(calibration.parts, sensitivities)
    folds = _Folds(calibration.machine, observed, moved, x, designs)
    left = folds.left()
    spread = folds.spread(max(1.0, float(left.sum()) / left.size))
    estimates = intervals(base, moved, x, spread)
    calibrated = replace(calibration, parameters=estimates)
    return Fit(base, calibrated, tuple(observed), left, folds.other_position())


class _Folds:
    """Recalibration on all runs but one, for every one of them.

    Unknown are the parameters that calibration moves, which are simulated, and everything else that
    is known to a range only, which is linear; what only one run has is minimised over inside it.
    """

    def __init__(
        self,
        machine: Machine,
        observed: Sequence[Observations],
        moved: Priors,
        x: FloatArray,
        designs: Sequence[RunDesign],
    ) -> None:
        self._machine, self._observed, self._moved = machine, observed, moved
        self._designs = designs
        self._clean = [design.cleaned(design.shared) for design in designs]
        self._grams = np.array(
            [d.shared.T @ clean for d, clean in zip(designs, self._clean, strict=True)]
        )
        total, prior = self._grams.sum(axis=0), np.eye(self._grams.shape[1])
        self._all = total + prior
        self._others = total - self._grams + prior
        self._count = len(x)
        self._start = np.pad(x, (0, self._grams.shape[1] - len(x)))

    def other_position(self) -> FloatArray:
        """Return where the unknowns that calibration does not move lie, shape (Q - P,)."""
        pairs = zip(self._clean, self._designs, strict=True)
        slope = sum(clean[:, self._count :].T @ design.residual for clean, design in pairs)
        return np.asarray(-np.linalg.solve(self._all[self._count :, self._count :], slope))

    def spread(self, unit: float) -> FloatArray:
        """Return standard deviations of what calibration moves, shape (P,), in the fitting scale.

        Parameters
        ----------
        unit : float
            What is left per run and channel: where that is more than the tolerance explains, what
            the runs say is less certain by as much.
        """
        covariance = np.linalg.inv(self._all)
        spread = np.sqrt(np.diag(covariance))[: self._count]
        for design in self._designs:
            spread[list(design.alone)] = design.deviations_alone(covariance)
        return np.asarray(np.minimum(spread * np.sqrt(unit), 1.0))

    def left(self) -> FloatArray:
        """Return what is left of each run and channel, predicted from the other runs, (R, C)."""
        runs = range(len(self._designs))
        point = np.tile(self._start, (len(runs), 1))
        # At the calibrated point nothing need be simulated.
        shown = [np.tile(design.residual, (len(runs), 1)) for design in self._designs]
        cost = self._training(point, shown)
        share = np.ones((len(runs), 1))
        for _ in range(FOLD_STEPS):
            # A step that its own runs do not bear out is not taken, and the next is shorter.
            trial = point + share * (self._stepped(point, shown) - point)
            simulated = self._simulated(trial)
            now = self._training(trial, simulated)
            better = (now < cost)[:, None]
            shown = [np.where(better, *pair) for pair in zip(simulated, shown, strict=True)]
            point, cost = np.where(better, trial, point), np.minimum(now, cost)
            share = np.where(better, share, SHORTER * share)
        channels = len(self._observed[0].channels)
        squares = []
        for k in runs:
            own = shown[k][k]
            left = own * self._designs[k].cleaned(own[:, None])[:, 0]
            squares.append(left.reshape(-1, channels).sum(axis=0))
        return np.array(squares)

    def _stepped(self, point: FloatArray, shown: Sequence[FloatArray]) -> FloatArray:
        """Return each fold's unknowns after a step on the runs that are not left out, (R, Q)."""
        slopes = np.array([residuals @ c for residuals, c in zip(shown, self._clean, strict=True)])
        total = slopes.sum(axis=0)
        stepped = point.copy()
        for k, others in enumerate(self._others):
            stepped[k] -= np.linalg.solve(others, total[k] - slopes[k, k] + point[k])
        moved, count = self._moved, self._count
        # As in calibration: derivatives know little of what is farther away.
        change = np.clip(stepped[:, :count] - point[:, :count], -FAR, FAR)
        stepped[:, :count] = point[:, :count] + change
        stepped[:, :count] = np.clip(stepped[:, :count], moved.low, moved.high)
        return stepped

    def _simulated(self, point: FloatArray) -> list[FloatArray]:
        """Return every run's residuals with the numbers of every fold, each (R, N)."""
        values = self._moved.values(point[:, : self._count])
        residuals = []
        shown = residuals_of(self._machine, self._observed, values)
        for residual, design in zip(shown, self._designs, strict=True):
            by_others = design.shared[:, self._count :] @ point[:, self._count :].T
            residuals.append(residual * design.weight + by_others.T)
        return residuals

    def _training(self, point: FloatArray, shown: Sequence[FloatArray]) -> FloatArray:
        """Return the cost of every fold's own runs, shape (R,)."""
        squares = np.array(
            [
                np.sum(residuals.T * design.cleaned(residuals.T), axis=0)
                for residuals, design in zip(shown, self._designs, strict=True)
            ]
        )
        prior: FloatArray = np.sum(point**2, axis=1)
        return np.asarray(squares.sum(axis=0) - np.diag(squares) + prior)
