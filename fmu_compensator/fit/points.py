"""Choose the temperature-sensitive points: group alike sensors, keep the most telling of each."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from fmu_compensator.fit.data import PreparedRun
from fmu_compensator.fit.incidence import IMAGES, comprehensive_degree, groups, relational_degree
from fmu_compensator.fit.training import Array
from measurement.errors import BadInput

GRID_S = 60.0
"""Degrees of incidence sum samples, so all runs are put on this one time grid first [s]."""
NEAR_CONSTANT_K = 0.3
"""A sensor whose 5 to 95 % range of rises is smaller carries noise and no news [K]."""


@dataclass(frozen=True)
class Choice:
    """Which sensors were chosen, and why.

    Attributes
    ----------
    chosen : list of int
        Indices of the chosen sensors, ascending.
    groups : list of list of int
        The groups; one sensor of each is chosen.
    scores : dict
        Degree (or correlation) to the error of each candidate, by index [1].
    quiet : list of int
        Candidates left out because they hardly move.
    """

    chosen: list[int]
    groups: list[list[int]]
    scores: dict[int, float]
    quiet: list[int]

    def table(self, sensors: Sequence[str]) -> dict[str, Any]:
        """Return the choice with names, for the file's provenance."""
        return {
            "groups": [[sensors[i] for i in group] for group in self.groups],
            "scores": {sensors[i]: round(score, 6) for i, score in self.scores.items()},
            "hardly_moving": [sensors[i] for i in self.quiet],
        }


def choose_points(
    runs: Sequence[PreparedRun],
    candidates: Sequence[int],
    *,
    threshold: float = 0.9,
    theta: float = 0.5,
    image: str = "initial",
    score: str = "correlation",
) -> Choice:
    """Group the candidates by grey comprehensive degree and keep one of each group.

    Parameters
    ----------
    runs : sequence of PreparedRun
        Their degrees are averaged, weighted by duration.
    candidates : sequence of int
        Indices of the sensors to choose from.
    threshold : float
        The significance level lambda: sensors with at least this degree form one group.
    theta, image
        Of `comprehensive_degree`.
    score : {"correlation", "relational"}
        What makes a sensor the best of its group: the size of Pearson's r with the error, or the
        grey relational degree to it; either way the mean over all targets. A falling target
        counts like its mirror image. On a measured lathe the correlation chose better.

    Raises
    ------
    BadInput
        If every candidate hardly moves, an option is not allowed, or the initial-value image does
        not exist because a temperature starts at 0 degC.
    """
    for place, text, allowed in (("score", score, SCORES), ("image", image, IMAGES)):
        if text not in allowed:
            raise BadInput("points", place, f"{text!r} is not allowed: {', '.join(allowed)}")
    for place, value in (("lambda", threshold), ("theta", theta)):
        if not 0 <= value <= 1:
            raise BadInput("points", place, f"{value:g} is not allowed: must be from 0 to 1")
    grids = [_on_grid(run, candidates) for run in runs]
    rises = np.concatenate([temperatures - temperatures[0] for temperatures, _ in grids])
    errors = np.concatenate([targets - targets[0] for _, targets in grids])
    spread = np.subtract(*np.percentile(rises, [95, 5], axis=0))
    loud = [place for place in range(len(candidates)) if spread[place] >= NEAR_CONSTANT_K]
    if not loud:
        raise BadInput(
            "training runs",
            "",
            f"no temperature moves by {NEAR_CONSTANT_K:g} K: none can be chosen",
        )
    degree = np.zeros((len(loud), len(loud)))
    for temperatures, _ in grids:
        try:
            one = comprehensive_degree(temperatures[:, loud], theta, image)
        except ValueError as error:
            raise BadInput("points", image, f"{error}; take another image") from None
        degree += one * len(temperatures) / len(rises)
    values = SCORES[score](errors, rises[:, loud])
    members = groups(degree, threshold)
    best = [max(group, key=lambda place: values[place]) for group in members]
    return Choice(
        chosen=sorted(candidates[loud[place]] for place in best),
        groups=[[candidates[loud[place]] for place in group] for group in members],
        scores={candidates[loud[place]]: float(values[place]) for place in range(len(loud))},
        quiet=[c for place, c in enumerate(candidates) if place not in loud],
    )


def _on_grid(run: PreparedRun, candidates: Sequence[int]) -> tuple[Array, Array]:
    """Return a run's temperatures and targets, evenly sampled where they were measured."""
    rows = run.usable & np.isfinite(run.targets).all(axis=1)
    if rows.sum() < 2:
        raise BadInput(run.name, "", "has fewer than 2 rows with all displacements")
    time = np.arange(run.time_s[rows][0], run.time_s[rows][-1], GRID_S)
    if len(time) < 3:
        raise BadInput(run.name, "", f"is shorter than {3 * GRID_S:g} s: too short to choose from")
    temperatures = np.column_stack(
        [_interpolated(time, run.time_s, run.temperatures[:, c]) for c in candidates]
    )
    targets = np.column_stack(
        [_interpolated(time, run.time_s[rows], target) for target in run.targets[rows].T]
    )
    return temperatures, targets


def _interpolated(time: Array, known: Array, values: Array) -> Array:
    there = np.isfinite(values)
    return np.interp(time, known[there], values[there])


def _relational(errors: Array, rises: Array) -> Array:
    """Return the grey relational degree of each column to the errors, either way up, mean."""
    degrees = [
        np.maximum(relational_degree(error, rises), relational_degree(-error, rises))
        for error in errors.T
    ]
    return np.asarray(np.mean(degrees, axis=0))


def _correlation(errors: Array, rises: Array) -> Array:
    """Return the size of Pearson's r of each column with the errors, mean over moving errors."""
    moving = errors[:, np.ptp(errors, axis=0) > 0]
    if moving.shape[1] == 0:
        return np.zeros(rises.shape[1])
    r = np.corrcoef(np.column_stack([rises, moving]), rowvar=False)
    return np.asarray(np.abs(r[: rises.shape[1], rises.shape[1] :]).mean(axis=1))


SCORES = {"relational": _relational, "correlation": _correlation}
