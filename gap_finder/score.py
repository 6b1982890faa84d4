"""Fits a hypothesis and measures how well it predicts left-out runs.

Every hypothesis, including "nothing", is fitted alike: calibrated on all runs, then in each fold on
all runs but one, which is simulated with the parameters of its fold.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import partial

import numpy as np
import numpy.typing as npt

from gap_finder.calibrate import Calibration, calibrate, intervals
from gap_finder.descent import ITERATIONS, Descent
from gap_finder.design import RunDesign, RunSensitivities, design_of
from gap_finder.linearise import residuals_at
from gap_finder.observations import Observations
from gap_finder.priors import FAR, Priors
from plant_model.machine import Machine
from plant_model.parameters import FloatArray

FIRST = 2
"""Iterations after which a calibration is abandoned if its cost exceeds a given limit; set for
time, on no data."""


@dataclass(frozen=True)
class Fit:
    """A machine, calibrated and scored run by run.

    Attributes
    ----------
    base : Machine
        Before calibration: its values are the centre of the prior.
    calibration : Calibration
    observed : tuple of Observations
    left : array, shape (R, C)
        Squared error of each run and channel when predicted from the other runs [tolerances
        squared, times the number of independent values].
    other_position : array, shape (Q - P,)
        Estimates of the unknowns that calibration does not move [standard deviations].
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
        """Squared error over all runs, each predicted from the others."""
        return float(self.left.sum())

    @property
    def moved_cost(self) -> float:
        """-2 log of the prior density of all unknowns at their estimates."""
        x = np.append(self.position(), self.other_position)
        return float(x @ x)

    @property
    def left_each(self) -> float:
        """Squared error per run and channel [tolerances squared]."""
        return self.cost / self.left.size

    def position(self) -> FloatArray:
        """Return the calibrated parameters in the fitting scale, shape (P,)."""
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
        Its values are the centre of the prior.
    observed : sequence of Observations
    start_from : sequence of Machine
        Starting points, of which the best result is kept.
    sensitivities : sequence of RunSensitivities
        Derivatives about a similar machine.
    cost_limit : float
        None is returned if the cost is not below this after a few iterations.
    """
    calibrated = partial(calibrate, base, observed, starts=1, sensitivities=sensitivities)
    begun = None
    if cost_limit < np.inf:
        begun = calibrated(iterations=FIRST, start_from=start_from)
        if begun.cost > cost_limit:
            return None
    calibration = calibrated(start_from=start_from, go_on=begun)
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


@dataclass(frozen=True)
class _Turn:
    """A rank-one update of all runs' derivatives that makes them exact along one step.

    C. G. Broyden, Math. Comp. 19 (1965) 577-593, doi:10.1090/S0025-5718-1965-0198670-6.

    Attributes
    ----------
    missed, clean : list of array, each (N,)
        Change in each run that they did not predict; the same without what the run's own unknowns
        imitate.
    along : array, shape (Q,)
        The step over its square.
    """

    missed: list[FloatArray]
    clean: list[FloatArray]
    along: FloatArray


@dataclass(eq=False, kw_only=True)
class _Fold(Descent):
    """Calibration without one run, with the initial derivatives updated after each step.

    Attributes
    ----------
    run : int
        The left-out run.
    shown : list of array
        Residuals of all runs at its current point, each (N,).
    matrix : array, shape (Q, Q)
        Normal matrix of the other runs, with the prior.
    turns : list of _Turn
    """

    run: int
    shown: list[FloatArray]
    matrix: FloatArray
    turns: list[_Turn] = field(default_factory=list)


class _Folds:
    """Recalibration without each run in turn.

    The unknowns are the parameters that calibration moves, which are simulated, and the others
    known only to a range, which are linear. Each run's own unknowns are eliminated within that run.
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
        """Return estimates of the unknowns that calibration does not move, shape (Q - P,)."""
        pairs = zip(self._clean, self._designs, strict=True)
        slope = sum(clean[:, self._count :].T @ design.residual for clean, design in pairs)
        return np.asarray(-np.linalg.solve(self._all[self._count :, self._count :], slope))

    def spread(self, unit: float) -> FloatArray:
        """Return the parameters' standard deviations in the fitting scale, shape (P,).

        Parameters
        ----------
        unit : float
            Squared error per run and channel: by how much the variance grows if the error exceeds
            the tolerance [tolerances squared].
        """
        covariance = np.linalg.inv(self._all)
        spread = np.sqrt(np.diag(covariance))[: self._count]
        for design in self._designs:
            spread[list(design.alone)] = design.deviations_alone(covariance)
        return np.asarray(np.minimum(spread * np.sqrt(unit), 1.0))

    def left(self) -> FloatArray:
        """Return the squared error of each run and channel, predicted from the others, (R, C)."""
        folds = self._folds()
        for _ in range(ITERATIONS):
            going = [fold for fold in folds if not fold.is_done]
            if not going:
                break
            trials = np.array([self._trials(fold) for fold in going])
            points = trials.reshape(-1, trials.shape[-1])
            shown = self._simulated(points)
            without = np.repeat([fold.run for fold in going], trials.shape[1])
            costs = self._costs(points, shown, without).reshape(trials.shape[:2])
            for i, fold in enumerate(going):
                before = fold.x
                taken = fold.take(trials[i], costs[i])
                told = trials.shape[1] - 1 if taken is None else taken
                seen = [of_run[i * trials.shape[1] + told] for of_run in shown]
                if not fold.is_done:
                    self._turn(fold, trials[i, told] - before, seen)
                if taken is not None:
                    fold.shown = seen
        channels = len(self._observed[0].channels)
        squares = []
        for fold, design in zip(folds, self._designs, strict=True):
            own = fold.shown[fold.run]
            left = own * design.cleaned(own[:, None])[:, 0]
            squares.append(left.reshape(-1, channels).sum(axis=0))
        return np.array(squares)

    def _folds(self) -> list[_Fold]:
        """Return all folds at the calibrated point, where residuals are already known."""
        shown = [design.residual for design in self._designs]
        runs = np.arange(len(shown))
        points = np.tile(self._start, (len(runs), 1))
        costs = self._costs(points, [np.tile(r, (len(runs), 1)) for r in shown], runs)
        return [
            _Fold(self._start, cost, run=run, shown=shown, matrix=self._others[run])
            for run, cost in enumerate(costs.tolist())
        ]

    def _trials(self, fold: _Fold) -> FloatArray:
        """Return the trial points of a fold from the runs that it keeps, shape (T, Q)."""
        slope = fold.x + self._slope(fold, fold.shown)
        matrix, count = fold.matrix, self._count
        diagonal = np.diag(np.diag(matrix))
        steps = np.array(
            [np.linalg.solve(matrix + damping * diagonal, -slope) for damping in fold.dampings]
        )
        # As in calibration: derivatives are unreliable farther away.
        steps[:, :count] = np.clip(steps[:, :count], -FAR, FAR)
        trials = np.asarray(fold.x + steps)
        trials[:, :count] = np.clip(trials[:, :count], self._moved.low, self._moved.high)
        return trials

    def _slope(self, fold: _Fold, residuals: Sequence[FloatArray]) -> FloatArray:
        """Return the gradient of a fold from residuals of the runs that it keeps, (Q,)."""
        kept = [run for run in range(len(residuals)) if run != fold.run]
        slope = np.sum([residuals[run] @ self._clean[run] for run in kept], axis=0)
        for turn in fold.turns:
            slope += turn.along * sum(float(residuals[run] @ turn.clean[run]) for run in kept)
        return np.asarray(slope)

    def _turn(self, fold: _Fold, step: FloatArray, seen: Sequence[FloatArray]) -> None:
        """Update a fold's derivatives so that they predict what a step changed."""
        if not all(np.isfinite(now).all() for now in seen):
            return
        moved = np.pad(step[: self._count], (0, len(step) - self._count))
        missed = []
        for run, (now, before) in enumerate(zip(seen, fold.shown, strict=True)):
            told = self._designs[run].shared @ step
            for turn in fold.turns:
                told += turn.missed[run] * float(turn.along @ step)
            missed.append(now - before - told)
        pairs = zip(self._designs, missed, strict=True)
        clean = [design.cleaned(part[:, None])[:, 0] for design, part in pairs]
        turn = _Turn(missed, clean, moved / max(float(moved @ moved), 1e-300))
        cross = np.outer(self._slope(fold, missed), turn.along)
        kept = [run for run in range(len(missed)) if run != fold.run]
        squares = sum(float(missed[run] @ clean[run]) for run in kept)
        fold.matrix = fold.matrix + cross + cross.T + squares * np.outer(turn.along, turn.along)
        fold.turns.append(turn)

    def _simulated(self, points: FloatArray) -> list[FloatArray]:
        """Return every run's residuals, each (S, N), at some points, (S, Q)."""
        residuals = []
        moved = points[:, : self._count]
        shown = residuals_at(self._machine, self._observed, self._moved, moved)
        for residual, design in zip(shown, self._designs, strict=True):
            by_others = design.shared[:, self._count :] @ points[:, self._count :].T
            residuals.append(residual * design.weight + by_others.T)
        return residuals

    def _costs(
        self, points: FloatArray, shown: Sequence[FloatArray], without: npt.NDArray[np.int64]
    ) -> FloatArray:
        """Return the costs, (S,), at some points, (S, Q), each without one of the runs."""
        squares = np.array(
            [
                np.sum(residuals.T * design.cleaned(residuals.T), axis=0)
                for residuals, design in zip(shown, self._designs, strict=True)
            ]
        )
        left_out = squares[without, np.arange(len(points))]
        return np.asarray(squares.sum(axis=0) - left_out + np.sum(points**2, axis=1))
