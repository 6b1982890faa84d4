"""The remaining drift that `fit` may promise, from runs and conditions left out.

What would be installed is judged: for each fold it is fitted without some runs, made into a
compensator, and driven through them with all its checks. Few runs say little about how large an
error may become, so the promise is the posterior of its mean square: the expectation of the
interval counts as `DEGREES` runs, next to the number of left-out runs or conditions. An interval
that expected less than was observed does not lower the observed value.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from fmu_compensator.driving import Driven, drive
from fmu_compensator.fit.conditions import LIKE, THIRDS, UNLIKE, Fold
from fmu_compensator.fit.gaussian import DEGREES
from fmu_compensator.fit.installed import RMS_OF_HALF_WIDTH
from fmu_compensator.leaps import leap_lines, leaps_of
from fmu_compensator.runtime.compensator import UNTRAINED
from fmu_compensator.runtime.modelfile import Model
from fmu_compensator.signs import opposite_axes
from measurement.rig import AXES, Rig
from measurement.runs import Run

FEWEST_JUDGED_ROWS = 2
"""Fewest measurements of a run that is judged or learnt from, given by arithmetic: the first sets
the zero [1]."""


@dataclass(frozen=True)
class AxisLeft:
    """The remaining drift of one run along one axis.

    Attributes
    ----------
    none, left : float
        Root mean square of the drift and of the remaining drift [um].
    inside : float
        Share of samples within the promised interval [1]; like the rest, NaN without an interval.
    half_width : float
        Mean half width of the interval [um].
    expected : float
        Root mean square of the remaining drift expected by the interval [um].
    miss : float
        Root mean square of the ratio of remaining drift to half width [1].
    """

    none: float
    left: float
    inside: float
    half_width: float
    expected: float
    miss: float


@dataclass(frozen=True)
class RunLeft:
    """The remaining drift of one run.

    Attributes
    ----------
    run : str
    fold : Fold or None
        The runs left out together with it; None if the compensator was given.
    axes : dict of str to AxisLeft
        The measured axes.
    new : float
        Share of samples outside training [1].
    counts : float
        Weight as a number of runs: below 1 if it is shorter than all training runs [1].
    leaps : tuple of str
        Leaps of the remaining drift that no switch of the machine explains, in words.
    opposite : tuple of str
        Axes that drift with the opposite sign of what the compensator learnt.
    """

    run: str
    fold: Fold | None
    axes: dict[str, AxisLeft]
    new: float
    counts: float = 1.0
    leaps: tuple[str, ...] = ()
    opposite: tuple[str, ...] = ()


def left_of(driven: Driven, run: str) -> RunLeft:
    """Return the remaining drift of a run."""
    axes: dict[str, AxisLeft] = {}
    error, width = driven.error, driven.half_width
    for place, axis in enumerate(AXES):
        known = np.isfinite(error[:, place])
        if known.sum() < FEWEST_JUDGED_ROWS:
            continue
        missed, half = error[known, place], width[known, place]
        axes[axis] = AxisLeft(
            _rms(driven.drift[known, place]),
            _rms(missed),
            float(np.mean(np.abs(missed) <= half)) if np.isfinite(half).all() else np.nan,
            float(np.mean(half)),
            RMS_OF_HALF_WIDTH * _rms(half),
            _rms(missed / half),
        )
    return RunLeft(run, None, axes, float(np.mean(driven.status == UNTRAINED)))


def judge_runs(
    model: Model, pairs: Iterable[tuple[Run, Run]], rig: Rig, tool_length_mm: float
) -> list[RunLeft]:
    """Return the remaining drift of runs with a compensator.

    Parameters
    ----------
    model : Model
        The compensator.
    pairs : iterable of (Run, Run)
        Each run as recorded, and without its broken readings.
    rig : Rig
        Meaning of the displacements.
    tool_length_mm : float
        Tool length at which the drift is taken.
    """
    records = []
    for run, left in pairs:
        driven = drive(model, run, left, rig, tool_length_mm)
        leaps = tuple(leaps_of(run, driven).values())
        opposite = opposite_axes(driven.drift, driven.error)
        records.append(replace(left_of(driven, run.name), leaps=leaps, opposite=opposite))
    return records


def leap_notes(records: Iterable[RunLeft]) -> list[str]:
    """Return a line for each leap of the remaining drift."""
    return leap_lines((record.run, record.leaps) for record in records)


def by_axis(records: Sequence[RunLeft]) -> dict[str, dict[str, float]]:
    """Return the remaining drift along each axis, with every run weighted by its `counts`.

    Parameters
    ----------
    records : sequence of RunLeft

    Returns
    -------
    dict of str to dict of str to float
        By axis: RMSE with the compensator (``model``), without (``no_model``) and as expected by
        the interval (``expected``) [um]; share of samples within the interval (``inside``) [1].
    """
    errors: dict[str, dict[str, float]] = {}
    for axis in AXES:
        here = [record for record in records if axis in record.axes]
        if not here:
            continue
        parts, counts = [record.axes[axis] for record in here], [record.counts for record in here]
        errors[axis] = {
            "model": _pooled([part.left for part in parts], counts),
            "no_model": _pooled([part.none for part in parts], counts),
            "expected": _pooled([part.expected for part in parts], counts),
            "inside": float(np.average([part.inside for part in parts], weights=counts)),
        }
    return errors


def promise(records: Sequence[RunLeft]) -> dict[str, Any] | None:
    """Return the results of left-out runs for the provenance; None if there are none.

    Every run counts as one.
    """
    records = [record for record in records if record.axes]
    if not records:
        return None
    results: dict[str, Any] = {}
    for kind in (LIKE, UNLIKE):
        here = [
            record for record in records if record.fold is not None and record.fold.kind == kind
        ]
        if not here:
            continue
        results[kind] = by_axis(here)
        by_fold = {record.fold.name: record.fold for record in here if record.fold is not None}
        runs = {record.run for record in here}
        # The folds of different conditions overlap: they are thirds of the same runs.
        results[f"{kind}_behind"] = len(runs) if kind == LIKE else min(len(runs), THIRDS)
        results[f"{kind}_folds"] = [
            {"left_out": name, "runs": len(fold.out), "ratio_to_none": _ratio(here, fold)}
            for name, fold in by_fold.items()
        ]
    results["by_run"] = _misses(
        record for record in records if record.fold and record.fold.kind == LIKE
    )
    return {**results, "promised": promised(results)}


def promised(unseen: Mapping[str, Any]) -> dict[str, dict[str, float]]:
    """Return the promised error of each axis (``model``), and the drift (``no_model``) [um].

    Parameters
    ----------
    unseen : mapping
        What `promise` returned: the worse of like and unlike runs is used.
    """
    kinds = [kind for kind in (LIKE, UNLIKE) if kind in unseen]
    promises = {}
    for axis in unseen[kinds[0]]:
        rows = [(unseen[kind][axis], unseen[f"{kind}_behind"]) for kind in kinds]
        square, none = max(
            (
                (DEGREES * max(row["expected"], row["model"]) ** 2 + behind * row["model"] ** 2)
                / (DEGREES + behind),
                row["no_model"],
            )
            for row, behind in rows
        )
        promises[axis] = {"model": float(np.sqrt(square)), "no_model": none}
    return promises


def followed(unseen: Mapping[str, Any] | None, records: Sequence[RunLeft]) -> dict[str, Any] | None:
    """Return a promise after new runs: each is one more run, together they are one more condition.

    Parameters
    ----------
    unseen : mapping or None
        What `promise` returned for the earlier runs; None: no earlier runs.
    records : sequence of RunLeft
        Remaining drift of the new runs with compensators not fitted to them.
    """
    records = [record for record in records if record.axes]
    if not records:
        return None if unseen is None else dict(unseen)
    new, results = by_axis(records), dict(unseen if unseen and "promised" in unseen else {})
    runs = sum(record.counts for record in records)
    for kind, count in ((LIKE, runs), (UNLIKE, runs / len(records))):
        if kind in results or kind == LIKE:
            behind = results.get(f"{kind}_behind", 0)
            results[kind] = _together(results.get(kind, {}), behind, new, count)
            results[f"{kind}_behind"] = behind + count
    results["by_run"] = [*results.get("by_run", ()), *_misses(records)]
    return {**results, "promised": promised(results)}


def _together(
    old: Mapping[str, Mapping[str, float]],
    behind: float,
    new: Mapping[str, Mapping[str, float]],
    count: float,
) -> dict[str, dict[str, float]]:
    """Return the combined figures by axis of *behind* observations and *count* more."""
    merged = {axis: dict(row) for axis, row in {**new, **old}.items()}
    for axis in old.keys() & new.keys():
        for name, value in new[axis].items():
            power = 1.0 if name == "inside" else 2.0
            total = behind * old[axis][name] ** power + count * value**power
            merged[axis][name] = float((total / (behind + count)) ** (1.0 / power))
    return merged


def _misses(records: Iterable[RunLeft]) -> list[dict[str, Any]]:
    return [
        {
            "run": record.run,
            "miss": [record.axes[axis].miss if axis in record.axes else None for axis in AXES],
            "new": record.new,
        }
        for record in records
    ]


def _ratio(records: Sequence[RunLeft], fold: Fold) -> float:
    """Return the error over that of no compensation, geometric mean over the axes [1]."""
    here = [record for record in records if record.fold == fold]
    logs = [
        np.log(max(error["model"], 1e-9) / error["no_model"])
        for error in by_axis(here).values()
        if error["no_model"] > 0.0
    ]
    return float(np.exp(np.mean(logs))) if logs else float("nan")


def _pooled(values: Sequence[float], counts: Sequence[float]) -> float:
    return float(np.sqrt(np.average(np.square(values), weights=counts)))


def _rms(values: np.ndarray) -> float:
    return float(np.sqrt(np.mean(values**2)))
