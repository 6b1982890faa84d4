"""Every run predicted from the others, with all unknowns linear about the calibrated machine.

Recalibrating without a run then only takes sums over the other runs, and no simulation.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from typing import Any

import numpy as np
import numpy.typing as npt
from scipy.linalg import cho_factor, cho_solve

from gap_finder.design import RunDesign
from plant_model.parameters import FloatArray

Runs = npt.NDArray[np.intp]
"""Positions of runs."""


class LeaveOneOut:
    """The normal equations of the unknowns that all runs share.

    Each run's own unknowns are eliminated within that run.

    Parameters
    ----------
    designs : sequence of RunDesign
        Of every run, about the calibrated machine.
    calibrated : array, shape (P,)
        The parameters that calibration moves, in the fitting scale. They come first among the Q
        shared unknowns; the others are 0.

    Attributes
    ----------
    designs : tuple of RunDesign
    clean : list of array, each (N, Q)
        Shared columns of every run, minus what its own unknowns can imitate.
    calibrated : int
        Number of parameters that calibration moves, P.
    position : array, shape (Q,)
        Distance of the shared unknowns from the centre of their prior.
    grams : array, shape (R, Q, Q)
        Normal matrix of every run.
    slopes : array, shape (R, Q)
        Half the gradient of every run's squared residual.
    every : array, shape (R,)
        The positions of all runs.
    """

    def __init__(self, designs: Sequence[RunDesign], calibrated: FloatArray) -> None:
        self.designs, self.every = tuple(designs), np.arange(len(designs))
        self.clean = [design.cleaned(design.shared) for design in designs]
        pairs = list(zip(designs, self.clean, strict=True))
        self.grams = np.array([design.shared.T @ columns for design, columns in pairs])
        self.slopes = np.array([columns.T @ design.residual for design, columns in pairs])
        self.calibrated = len(calibrated)
        self.position = np.pad(calibrated, (0, self.grams.shape[1] - self.calibrated))

    def without(self, run: int) -> Runs:
        """Return the positions of all runs but one."""
        return np.delete(self.every, run)

    def normal(self, runs: Runs) -> FloatArray:
        """Return the normal matrix of some runs with the prior, (Q, Q)."""
        return np.asarray(self.grams[runs].sum(axis=0) + np.eye(len(self.position)))

    def recalibrated(self, runs: Runs) -> tuple[Any, FloatArray]:
        """Return the factored normal matrix of some runs, and the step to their best fit, (Q,)."""
        factor = cho_factor(self.normal(runs))
        return factor, -cho_solve(factor, self.slopes[runs].sum(axis=0) + self.position)

    def left(self, channels: int) -> FloatArray:
        """Return the squared error of each run and channel, predicted from the others, (R, C).

        In the designs' units.
        """
        squares = []
        for run, design in enumerate(self.designs):
            missed = design.residual + design.shared @ self.recalibrated(self.without(run))[1]
            left = missed * design.cleaned(missed[:, None])[:, 0]
            squares.append(left.reshape(-1, channels).sum(axis=0))
        return np.array(squares)

    def other_position(self) -> FloatArray:
        """Return estimates of the unknowns that calibration does not move, shape (Q - P,)."""
        inner = self.normal(self.every)[self.calibrated :, self.calibrated :]
        return np.asarray(-np.linalg.solve(inner, self.slopes.sum(axis=0)[self.calibrated :]))

    @cached_property
    def _covariance(self) -> FloatArray:
        """Of the shared unknowns, from all runs, (Q, Q)."""
        return np.asarray(np.linalg.inv(self.normal(self.every)))

    def determined(self) -> float:
        """Return as how many independent numbers the runs determine the calibrated ones [1]."""
        return float(np.sum(1.0 - np.diag(self._covariance)[: self.calibrated]))

    def spread(self, unit: float) -> FloatArray:
        """Return the parameters' standard deviations in the fitting scale, shape (P,).

        Parameters
        ----------
        unit : float
            Squared error per left-out run and channel: by how much the variance grows, because the
            errors within a run depend on each other [squared units of the channels].
        """
        spread = np.sqrt(np.diag(self._covariance))[: self.calibrated]
        for design in self.designs:
            spread[list(design.alone)] = design.deviations_alone(self._covariance)
        return np.asarray(np.minimum(spread * np.sqrt(unit), 1.0))
