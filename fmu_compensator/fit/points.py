"""Choose the temperature-sensitive points: group similar sensors and keep the best of each."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from fmu_compensator.fit.clustering import fuzzy_c_means, hierarchical
from fmu_compensator.fit.data import PreparedRun, moved_by
from fmu_compensator.fit.incidence import (
    AS_READ,
    IMAGES,
    NoImageError,
    comprehensive_degree,
    groups,
    relational_degree,
)
from fmu_compensator.fit.training import GRID_S, Array
from measurement.errors import BadInput, refuse_other, shown
from measurement.faults.series import UNUSUALLY
from measurement.resampling import FINEST_K
from measurement.rig import axis_of

NEAR_CONSTANT_K = UNUSUALLY * FINEST_K
"""A sensor that moves by less than this, without noise, carries no information [K]."""
GROWTH = "growth"
"""Name for the target that the studies score by, whatever its name: elongation, else the one that
measures Z, else the first."""


@dataclass(frozen=True)
class Choice:
    """The chosen sensors, and the reasons.

    Attributes
    ----------
    chosen : list of int
        Indices of the chosen sensors, ascending.
    groups : list of list of int
        The groups; one sensor of each is chosen.
    scores : dict
        Degree (or correlation) of each candidate with the error, by index [1].
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
    absolute_image: str = AS_READ,
    score: str = "correlation",
    target: int | None = None,
    grouping: str = "grey",
    clusters: int = 4,
    variables: int | None = None,
    keep_quiet: bool = False,
    names: Sequence[str] = (),
) -> Choice:
    """Group the candidates and choose one of each group.

    Parameters
    ----------
    runs : sequence of PreparedRun
        Their degrees are averaged, weighted by duration.
    candidates : sequence of int
        Indices of the sensors to choose from.
    threshold : float
        The significance level lambda: sensors with at least this degree are grouped.
    theta, image, absolute_image
        Of `comprehensive_degree`.
    grouping : {"grey", "hierarchical", "fuzzy"}
        By grey comprehensive degree, by hierarchical clustering of the rises (Euclidean distance,
        centroid linkage), or by fuzzy c-means.
    clusters : int
        Number of groups of the latter two.
    variables : int, optional
        Number of sensors to choose, if available: one of each group, then the best of the rest.
        The time-series study has five from four groups without saying how.
    keep_quiet : bool
        Include sensors that hardly move, as the studies do with the ambient air.
    score : {"correlation", "relational"}
        Criterion for the best sensor of a group: the absolute value of Pearson's r with the error,
        or the grey relational degree to it. A falling target counts like its mirror image. On a
        measured lathe the correlation chose better.
    target : int, optional
        The target to score against, such as elongation in the studies; by default the mean over
        all targets.
    names : sequence of str, optional
        Names of all sensors, for messages.

    Raises
    ------
    BadInput
        If no candidate moves noticeably, an option is not allowed, or an image does not exist
        because a temperature starts at 0, as recorded rises do.
    """
    refuse_grey(threshold, theta, image, absolute_image)
    refuse_other("points", "score", score, SCORES)
    refuse_other("points", "grouping", grouping, GROUPINGS)
    grids = [on_grid(run, candidates) for run in runs]
    rises = np.concatenate([temperatures - temperatures[0] for temperatures, _ in grids])
    errors = np.concatenate([targets - targets[0] for _, targets in grids])
    if target is not None:
        errors = errors[:, [target]]
    spread = moved_by(rises)
    loud = [p for p in range(len(candidates)) if keep_quiet or spread[p] >= NEAR_CONSTANT_K]
    if not loud:
        raise BadInput(
            "training runs",
            "",
            f"no temperature moves by {NEAR_CONSTANT_K:g} K: none can be chosen",
        )
    values = SCORES[score](errors, rises[:, loud])
    if grouping == "grey":
        parts = {run.name: grid[:, loud] for run, (grid, _) in zip(runs, grids, strict=True)}
        labels = [names[candidates[place]] for place in loud] if names else ()
        degree = mean_degree(parts, theta, image, absolute_image, names=labels)
        members = groups(degree, threshold)
    else:
        if not 1 <= clusters <= len(loud):
            problem = f"{clusters} is not allowed: 1 to {len(loud)}, the temperatures that move"
            raise BadInput("points", "clusters", problem)
        if grouping == "hierarchical":
            members = hierarchical(rises[:, loud], clusters)
        else:
            members = fuzzy_c_means(rises[:, loud], clusters).groups
    best = [max(group, key=lambda place: values[place]) for group in members]
    if variables is not None:
        if variables < len(best):
            problem = f"{variables} is not allowed: at least one of each of {len(best)} groups"
            raise BadInput("points", "variables", problem)
        rest = sorted(set(range(len(loud))) - set(best), key=lambda place: -values[place])
        best += rest[: variables - len(best)]
    return Choice(
        chosen=sorted(candidates[loud[place]] for place in best),
        groups=[[candidates[loud[place]] for place in group] for group in members],
        scores={candidates[loud[place]]: float(values[place]) for place in range(len(loud))},
        quiet=[c for place, c in enumerate(candidates) if place not in loud],
    )


def refuse_grey(threshold: float, theta: float, image: str, absolute_image: str) -> None:
    """Refuse options of the grey grouping that are not allowed.

    Raises
    ------
    BadInput
        Names the first one.
    """
    for place, value in (("lambda", threshold), ("theta", theta)):
        if not 0 <= value <= 1:
            raise BadInput("points", place, f"{value:g} is not allowed: must be from 0 to 1")
    refuse_other("points", "image", image, IMAGES)
    refuse_other("points", "absolute image", absolute_image, (AS_READ, *IMAGES))


def mean_degree(
    parts: Mapping[str, Array],
    theta: float = 0.5,
    image: str = "initial",
    absolute_image: str = AS_READ,
    *,
    names: Sequence[str] = (),
) -> Array:
    """Return the grey comprehensive degree, mean over runs, weighted by their length.

    Parameters
    ----------
    parts : mapping of str to array (n, m)
        Each run's temperatures on an even grid, by the run's name [degC].
    theta, image, absolute_image
        Of `comprehensive_degree`.
    names : sequence of str, optional
        Names of the temperatures, for messages.

    Raises
    ------
    BadInput
        If the dimensionless form does not exist for some series.
    """
    total = sum(len(part) for part in parts.values())
    degrees = []
    for run, part in parts.items():
        try:
            degree = comprehensive_degree(part, theta, image, absolute_image)
        except NoImageError as missing:
            sensor = names[missing.column] if names else f"column {missing.column}"
            problem = (
                f"{sensor} {missing.why}. Temperatures recorded as rises all start at 0: "
                "give them as read, or take --image interval"
            )
            raise BadInput(run, "points", problem) from None
        degrees.append(degree * len(part) / total)
    return np.asarray(np.sum(degrees, axis=0))


def target_place(targets: Sequence[str], target: str, source: str) -> int:
    """Return the place of a target by its name, with or without its unit.

    Parameters
    ----------
    targets : sequence of str
        What the runs measure.
    target : str
        One of them, or `GROWTH`.
    source : str
        The origin of the request, for the error message.

    Raises
    ------
    BadInput
        If there is no target with this name.
    """
    name = target.removesuffix("_um").removesuffix("_urad")
    if name == GROWTH and GROWTH not in targets:
        along = (k for k, known in enumerate(targets) if "Z" in (axis_of(known) or ()))
        return list(targets).index("elongation") if "elongation" in targets else next(along, 0)
    if name not in targets:
        raise BadInput(source, "target", f"{shown(target)} is not allowed: {', '.join(targets)}")
    return list(targets).index(name)


def on_grid(run: PreparedRun, candidates: Sequence[int]) -> tuple[Array, Array]:
    """Return a run's temperatures and targets, evenly sampled where they were measured.

    Degrees of incidence sum samples, so all runs need the same grid.
    """
    rows = run.usable & np.isfinite(run.targets).all(axis=1)
    if rows.sum() < 2:
        raise BadInput(run.name, "", run.lost or "has fewer than 2 rows with all displacements")
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
    """Return the mean grey relational degree of each column to the errors or their negatives."""
    degrees = [
        np.maximum(relational_degree(error, rises), relational_degree(-error, rises))
        for error in errors.T
    ]
    return np.asarray(np.mean(degrees, axis=0))


def _correlation(errors: Array, rises: Array) -> Array:
    """Return the absolute Pearson's r of each column with the errors, mean over moving errors."""
    moving = errors[:, np.ptp(errors, axis=0) > 0]
    if moving.shape[1] == 0:
        return np.zeros(rises.shape[1])
    r = np.corrcoef(np.column_stack([rises, moving]), rowvar=False)
    return np.asarray(np.abs(r[: rises.shape[1], rises.shape[1] :]).mean(axis=1))


GROUPINGS = ("grey", "hierarchical", "fuzzy")
SCORES = {"relational": _relational, "correlation": _correlation}
