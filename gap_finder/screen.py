"""Screens how well each candidate explains the residuals of calibration, run by run.

A candidate is one more unknown of all runs: its response times a factor. Everything is linear, as
in the score.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.linalg import cho_solve

from gap_finder.added_paths import AT_ONCE
from gap_finder.candidates import LEAST_SCALE, MOST_SCALE
from gap_finder.design import RunDesign, told_by_one_run
from gap_finder.hypotheses import Addition
from gap_finder.leave_one_out import LeaveOneOut, Runs
from plant_model.parameters import FloatArray


@dataclass(frozen=True)
class Scores:
    """What each candidate leaves, with each run predicted from the others.

    Attributes
    ----------
    left : array, shape (m, C)
        Squared error of each channel over all runs, in the designs' units.
    numbers_gain, others_gain : array, shape (m,)
        Reduction of the squared distance of the file's numbers from their priors' centres, and of
        that of all other shared unknowns.
    scale : array, shape (m,)
        Factor on the candidate's response, from all runs together.
    position : array, shape (m, P)
        Where calibration then goes, in the fitting scale.
    """

    left: FloatArray
    numbers_gain: FloatArray
    others_gain: FloatArray
    scale: FloatArray
    position: FloatArray


class Screen:
    """Scores candidates.

    Parameters
    ----------
    runs : LeaveOneOut
    tried : sequence of Addition, length m
    channels : int
    """

    def __init__(self, runs: LeaveOneOut, tried: Sequence[Addition], channels: int) -> None:
        self._runs, self._tried, self._channels = runs, tried, channels
        count, many = len(runs.designs), len(tried)
        # Of every run: responses against the shared columns, themselves and the residual.
        self._cross = np.zeros((count, len(runs.position), many))
        self._squares, self._against = np.zeros((count, many)), np.zeros((count, many))
        for i, (design, shared) in enumerate(zip(runs.designs, runs.clean, strict=True)):
            residual = design.cleaned(design.residual[:, None])[:, 0]
            for block, columns in _in_blocks(tried, i, design):
                self._cross[i, :, block] = shared.T @ columns
                self._squares[i, block] = np.sum(columns * design.cleaned(columns), axis=0)
                self._against[i, block] = residual @ columns
        self._alone = told_by_one_run(self._squares)

    def scores(self) -> Scores:
        """Score every candidate."""
        runs = self._runs
        step, follow, scale = self._recalibrated(runs.every)
        reached = (runs.position + step)[:, None]
        with_it = reached - scale * follow
        gain = reached**2 - with_it**2
        numbers, others = (part.sum(axis=0) for part in np.split(gain, [runs.calibrated]))
        left = sum(self._predicted(run) for run in runs.every.tolist())
        return Scores(np.asarray(left), numbers, others, scale, with_it[: runs.calibrated].T)

    def _recalibrated(self, kept: Runs) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return what some runs make of the unknowns.

        The shared ones' step without any candidate, (Q,), by how much they move back per unit of
        each candidate, (Q, m), and the candidates' factors, (m,).
        """
        factor, step = self._runs.recalibrated(kept)
        cross = self._cross[kept].sum(axis=0)
        follow = cho_solve(factor, cross)
        squares = self._squares[kept].sum(axis=0) - np.sum(cross * follow, axis=0)
        slope = self._against[kept].sum(axis=0) + step @ cross
        scale = np.clip(-slope / np.maximum(squares, 1e-12), LEAST_SCALE, MOST_SCALE)
        return step, follow, scale

    def _predicted(self, run: int) -> FloatArray:
        """Return the squared error of a left-out run's channels with each candidate, (m, C)."""
        design = self._runs.designs[run]
        step, follow, scale = self._recalibrated(self._runs.without(run))
        base = (design.residual + design.shared @ step)[:, None]
        clean = design.cleaned(base)
        left = np.zeros((len(scale), self._channels))
        for block, columns in _in_blocks(self._tried, run, design):
            columns -= design.shared @ follow[:, block]
            cleaned = design.cleaned(columns)
            # A candidate that acts only in this run is the run's own unknown, like a zero.
            quadratic = np.maximum(np.sum(columns * cleaned, axis=0), 1e-12)
            best = np.clip(-np.sum(base * cleaned, axis=0) / quadratic, LEAST_SCALE, MOST_SCALE)
            size = np.where(self._alone[run, block], best, scale[block])
            squares = (base + columns * size) * (clean + cleaned * size)
            left[block] = squares.reshape(-1, self._channels, len(size)).sum(axis=0).T
        return left


def _in_blocks(
    tried: Sequence[Addition], run: int, design: RunDesign
) -> Iterator[tuple[slice, FloatArray]]:
    """Yield some candidates, and a run's robustly weighted responses to them, (N, b).

    All responses to the thousands of changes of a page would fill the memory.
    """
    for begin in range(0, len(tried), AT_ONCE):
        block = slice(begin, begin + AT_ONCE)
        answers = np.array([candidate.answers[run] for candidate in tried[block]])
        yield block, answers.T * design.weight[:, None]
