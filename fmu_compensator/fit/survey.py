"""All quantities that the studies use to choose temperature-sensitive points."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from fmu_compensator.fit.clustering import centroid_linkage, fuzzy_c_means, hierarchical
from fmu_compensator.fit.columns import MeasuredColumns, unit_of
from fmu_compensator.fit.correlation import MOST_CANDIDATES, Subset, all_subsets, pearson
from fmu_compensator.fit.data import moved_by, prepare
from fmu_compensator.fit.incidence import AS_READ, groups, relational_degree
from fmu_compensator.fit.loops import Loop, loop_of
from fmu_compensator.fit.points import (
    GROUPINGS,
    GROWTH,
    NEAR_CONSTANT_K,
    choose_points,
    mean_degree,
    on_grid,
    refuse_grey,
    target_place,
)
from fmu_compensator.fit.training import GRID_S, Array
from measurement.errors import BadInput, shown
from measurement.rig import Rig
from measurement.runs import Run


@dataclass(frozen=True)
class Survey:
    """Degrees, groups and combinations of the temperatures that move.

    Attributes
    ----------
    run_names, sensors : list of str
        Names of the runs and of the temperatures considered.
    target, unit : str
        The error to predict, and its unit.
    degree : array (m, m)
        Grey comprehensive degree [1].
    groupings : dict of str to list of list of int
        Groups of the columns, by method.
    linkage : array
        Of the hierarchical clustering, for a dendrogram.
    membership : array (m, clusters)
        Of fuzzy c-means [1].
    pearson, relational : array (m,)
        Correlation with the error, and grey relational degree to it [1].
    loops : list of Loop
        How the error follows each temperature.
    traces : list of (array (n, m), array (n,))
        Rises and error of each run, one sample every `GRID_S` [K; um, urad].
    points : list of int
        The columns chosen: the best of each group.
    subsets : list of Subset
        All combinations of the points; their columns are indices into `points`.
    notes : list of str
        What was left out of the data.
    """

    run_names: list[str]
    sensors: list[str]
    target: str
    unit: str
    degree: Array
    groupings: dict[str, list[list[int]]]
    linkage: Array
    membership: Array
    pearson: Array
    relational: Array
    loops: list[Loop]
    traces: list[tuple[Array, Array]]
    points: list[int]
    subsets: list[Subset]
    notes: list[str]

    def to_dict(self) -> dict[str, Any]:
        """Return everything in JSON types."""
        return {
            "runs": self.run_names,
            "sensors": self.sensors,
            "target": self.target,
            "unit": self.unit,
            "degree": np.round(self.degree, 6).tolist(),
            "groups": {
                name: [[self.sensors[i] for i in group] for group in groups]
                for name, groups in self.groupings.items()
            },
            "fuzzy_membership": np.round(self.membership, 6).tolist(),
            "pearson": dict(zip(self.sensors, np.round(self.pearson, 6).tolist(), strict=True)),
            "relational": dict(
                zip(self.sensors, np.round(self.relational, 6).tolist(), strict=True)
            ),
            "loops": {
                name: {key: round(value, 6) for key, value in asdict(loop).items()}
                for name, loop in zip(self.sensors, self.loops, strict=True)
            },
            "points": [self.sensors[i] for i in self.points],
            "subsets": [
                {
                    "temperatures": [self.sensors[self.points[i]] for i in subset.columns],
                    "multiple_r": _defined(subset.multiple_r),
                    "r2_adjusted": _defined(subset.r2_adjusted),
                    "held_out_rmse": _defined(subset.held_out_rmse),
                }
                for subset in self.subsets
            ],
            "notes": self.notes,
        }


def survey(
    runs: Sequence[Run],
    rig: Rig | MeasuredColumns,
    *,
    threshold: float = 0.9,
    theta: float = 0.5,
    image: str = "initial",
    absolute_image: str = AS_READ,
    clusters: int = 4,
    variables: int | None = None,
    keep_quiet: bool = False,
    score: str = "correlation",
    grouping: str = "grey",
    target: str = GROWTH,
) -> Survey:
    """Return how similar the temperatures of runs are, and how well they predict the error.

    Parameters
    ----------
    runs : sequence of Run
        Their degrees are averaged; the rises of all runs are clustered and correlated together.
    rig : rig or MeasuredColumns
        Meaning of the displacement columns.
    threshold : float
        Grey degree at which two temperatures join one group.
    theta : float
        Weight of the absolute degree in the comprehensive one.
    image : {"initial", "mean", "interval"}
        Dimensionless form for the relative degree.
    absolute_image : {"as_read", "initial", "mean", "interval"}
        Dimensionless form for the absolute degree; the jig-borer study uses initial here and mean
        for *image*.
    clusters : int
        Groups of the hierarchical and fuzzy clustering.
    variables : int, optional
        Number of temperatures to choose: one of each group, then the best of the rest (default: one
        of each group).
    keep_quiet : bool
        Also consider temperatures that hardly move.
    score : {"correlation", "relational"}
        Criterion for the best temperature of a group.
    grouping : {"grey", "hierarchical", "fuzzy"} or names
        Clustering from whose groups one temperature each is chosen, or the temperatures themselves,
        separated by commas.
    target : str
        Signal name of the error to predict, or ``growth``: elongation if measured, else the one
        that measures Z, else the first.

    Raises
    ------
    BadInput
        For an option that is not allowed, or runs in which fewer than two temperatures move.
    """
    prepared = prepare(runs, rig, "rise")
    place = target_place(prepared.targets, target, "points")
    refuse_grey(threshold, theta, image, absolute_image)
    _refuse_few(prepared.candidates)
    grids = [on_grid(run, prepared.candidates) for run in prepared.runs]
    moved = [temperatures - temperatures[0] for temperatures, _ in grids]
    errors = [targets[:, place] for _, targets in grids]
    rises, error = np.concatenate(moved), np.concatenate(errors)
    spread = moved_by(rises)
    loud = [k for k in range(rises.shape[1]) if keep_quiet or spread[k] >= NEAR_CONSTANT_K]
    _refuse_few(loud)
    if not 1 <= clusters <= len(loud):
        raise BadInput("points", "clusters", f"{clusters} is not allowed: 1 to {len(loud)}")
    moving = rises[:, loud]
    names = [prepared.sensors[prepared.candidates[k]] for k in loud]
    parts = {run.name: grid[:, loud] for run, (grid, _) in zip(prepared.runs, grids, strict=True)}
    degree = mean_degree(parts, theta, image, absolute_image, names=names)
    fuzzy = fuzzy_c_means(moving, clusters)
    groupings = {
        f"grey comprehensive degree, lambda {threshold:g}": groups(degree, threshold),
        "hierarchical, centroid linkage": hierarchical(moving, clusters),
        "fuzzy c-means": fuzzy.groups,
    }
    r = pearson(moving, error)
    relational = np.maximum(relational_degree(error, moving), relational_degree(-error, moving))
    if grouping in GROUPINGS:
        choice = choose_points(
            prepared.runs,
            prepared.candidates,
            threshold=threshold,
            theta=theta,
            image=image,
            absolute_image=absolute_image,
            score=score,
            target=place,
            grouping=grouping,
            clusters=clusters,
            variables=variables,
            keep_quiet=keep_quiet,
            names=prepared.sensors,
        )
        points = [names.index(prepared.sensors[index]) for index in choice.chosen]
    else:
        points = [_place(name.strip(), names) for name in grouping.split(",")]
    points = sorted(sorted(points, key=lambda k: -np.nan_to_num(abs(r[k])))[:MOST_CANDIDATES])
    traces = [(m[:, loud], e - e[0]) for m, e in zip(moved, errors, strict=True)]
    drifts = [drift for _, drift in traces]
    return Survey(
        [run.name for run in runs],
        names,
        prepared.targets[place],
        unit_of(rig, prepared.targets[place]),
        degree,
        groupings,
        centroid_linkage(moving),
        fuzzy.membership,
        np.nan_to_num(r),
        relational,
        [loop_of([r[:, k] for r, _ in traces], drifts, GRID_S) for k in range(len(names))],
        traces,
        points,
        all_subsets([(m[:, loud][:, points], e) for m, e in zip(moved, errors, strict=True)]),
        list(prepared.notes),
    )


def _refuse_few(moving: Sequence[int]) -> None:
    if len(moving) < 2:
        problem = f"{len(moving)} temperatures move by {NEAR_CONSTANT_K:g} K: 2 or more are needed"
        raise BadInput("runs", "", problem)


def _place(name: str, names: Sequence[str]) -> int:
    if name not in names:
        allowed = ", ".join((*GROUPINGS, *names))
        raise BadInput("points", "points", f"{shown(name)} is not allowed: {allowed}")
    return list(names).index(name)


def _defined(value: float) -> float | None:
    return round(value, 6) if math.isfinite(value) else None
