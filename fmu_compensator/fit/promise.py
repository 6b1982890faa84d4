"""What a compensator leaves in runs and in conditions left out: what `fit` may promise.

Judged is what would be installed: each time it is fitted anew without some runs, made into a
compensator, and driven through them with all its checks.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from fmu_compensator.driving import AXES, Driven, drive
from fmu_compensator.fit.conditions import LIKE, UNLIKE, Fold
from fmu_compensator.runtime.compensator import UNTRAINED
from fmu_compensator.runtime.modelfile import Model
from measurement.rig import Rig
from measurement.runs import Run


@dataclass(frozen=True)
class AxisLeft:
    """What a compensator leaves of the drift of one run along one axis.

    Attributes
    ----------
    none, left : float
        Root mean square of the drift, and of what is left of it [um].
    inside : float
        Share of the samples within the promised interval [1].
    half_width : float
        Mean half width of the interval [um].
    miss : float
        Root mean square of what is left over the half width [1].
    """

    none: float
    left: float
    inside: float
    half_width: float
    miss: float


@dataclass(frozen=True)
class RunLeft:
    """What a compensator leaves of the drift of one run.

    Attributes
    ----------
    run : str
    fold : Fold or None
        The runs left out together with it; None where the compensator was given.
    axes : dict of str to AxisLeft
        By axis; those that were measured.
    new : float
        Share of the samples outside training [1].
    """

    run: str
    fold: Fold | None
    axes: dict[str, AxisLeft]
    new: float


def left_of(driven: Driven, run: str, fold: Fold | None = None) -> RunLeft:
    """Return what was left of a run's drift."""
    axes = {}
    error, width = driven.error, driven.half_width
    for place, axis in enumerate(AXES):
        known = np.isfinite(error[:, place])
        if not known.any():
            continue
        missed, half = error[known, place], width[known, place]
        axes[axis] = AxisLeft(
            _rms(driven.drift[known, place]),
            _rms(missed),
            float(np.mean(np.abs(missed) <= half)),
            float(np.mean(half)),
            _rms(missed / half),
        )
    return RunLeft(run, fold, axes, float(np.mean(driven.status == UNTRAINED)))


def judge_runs(
    model: Model,
    pairs: Iterable[tuple[Run, Run]],
    rig: Rig,
    tool_length_mm: float,
    fold: Fold | None = None,
) -> list[RunLeft]:
    """Return what a compensator leaves of runs.

    Parameters
    ----------
    model : Model
        The compensator.
    pairs : iterable of (Run, Run)
        Each run as it was recorded, and without what is broken in it.
    rig : Rig
        What the displacements mean.
    tool_length_mm : float
        At which the drift is taken.
    fold : Fold, optional
        Put down with each.
    """
    return [
        left_of(drive(model, run, left, rig, tool_length_mm), run.name, fold) for run, left in pairs
    ]


def by_axis(records: Sequence[RunLeft]) -> dict[str, dict[str, float]]:
    """Return what is left along each axis, every run counting as one.

    Parameters
    ----------
    records : sequence of RunLeft

    Returns
    -------
    dict of str to dict of str to float
        By axis: RMSE with the compensator (``model``) and without (``no_model``) [um], share of
        the samples within the interval (``inside``) [1].
    """
    names = dict.fromkeys(axis for one in records for axis in one.axes)
    here = {axis: [one.axes[axis] for one in records if axis in one.axes] for axis in names}
    return {
        axis: {
            "model": _pooled([one.left for one in parts]),
            "no_model": _pooled([one.none for one in parts]),
            "inside": float(np.mean([one.inside for one in parts])),
        }
        for axis, parts in here.items()
    }


def promise(records: Sequence[RunLeft]) -> dict[str, Any] | None:
    """Return what runs left out showed, for the provenance; None without any.

    Every run counts as one.
    """
    records = [one for one in records if one.axes]
    if not records:
        return None
    found: dict[str, Any] = {}
    for kind in (LIKE, UNLIKE):
        here = [one for one in records if one.fold is not None and one.fold.kind == kind]
        if not here:
            continue
        found[kind] = by_axis(here)
        by_fold = {one.fold.name: one.fold for one in here if one.fold is not None}
        found[f"{kind}_folds"] = [
            {"left_out": name, "runs": len(fold.out), "ratio_to_none": _ratio(here, fold)}
            for name, fold in by_fold.items()
        ]
    found["by_run"] = [
        {
            "run": one.run,
            "miss": [one.axes[axis].miss if axis in one.axes else None for axis in AXES],
            "new": one.new,
        }
        for one in records
        if one.fold is not None and one.fold.kind == LIKE
    ]
    return found


def _ratio(records: Sequence[RunLeft], fold: Fold) -> float:
    """Return the error over that of no compensation, geometric mean over the axes [1]."""
    here = [one for one in records if one.fold == fold]
    logs = [
        np.log(max(found["model"], 1e-9) / found["no_model"])
        for found in by_axis(here).values()
        if found["no_model"] > 0.0
    ]
    return float(np.exp(np.mean(logs))) if logs else float("nan")


def _pooled(values: Sequence[float]) -> float:
    return float(np.sqrt(np.mean(np.square(values))))


def _rms(values: np.ndarray) -> float:
    return float(np.sqrt(np.mean(values**2)))
