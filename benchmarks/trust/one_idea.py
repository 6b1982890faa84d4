"""A reference to beat: one idea in a few lines, with nothing around it.

drift(t) = Phi(t) w + b(t) + e, target by target: rises of the thermometers and their lags of 10, 40
and 160 min, Gaussian weights with one scale a group of columns, a random walk of each run's own
size, white noise. The scales maximise the marginal likelihood.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from scipy.optimize import minimize

from benchmarks.trust.questions import Question
from fmu_compensator.driving import grid_rows
from fmu_compensator.fit.data import PreparedRun, prepare
from fmu_compensator.fit.promise import AxisLeft, RunLeft
from fmu_compensator.fit.training import Array
from fmu_compensator.runtime.fields import Fields
from fmu_compensator.runtime.geometry import Direct, geometry_from_fields
from measurement.rig import FivePointRig
from studies.fit.lagged import lagged

LAGS_MIN = (10.0, 40.0, 160.0)
EVERY = 10
FREEDOM = 6.0
WIDTH = 1.645
TOOL_MM = 100.0


def one_idea(question: Question) -> list[RunLeft]:
    """Return what the reference leaves of a question's judged runs."""
    prepared = prepare(question.train, question.rig)
    names = [prepared.sensors[index] for index in prepared.candidates]
    train = [_groups(run, list(prepared.candidates)) for run in prepared.runs]
    judged = prepare(question.judged, question.rig, sensors=names)
    columns = [judged.sensors.index(name) for name in names if name in judged.sensors]
    if len(columns) < len(names):
        return []
    test = [_groups(run, columns) for run in judged.runs]
    said, spread = [], []
    for target in range(len(prepared.targets)):
        known = [_rows(*pair, target) for pair in zip(prepared.runs, train, strict=True)]
        model = _robust([one for one in known if len(one[0]) >= 10])
        both = [
            _predicted(model, run, groups) for run, groups in zip(judged.runs, test, strict=True)
        ]
        said.append([mean for mean, _ in both])
        spread.append([deviation for _, deviation in both])
    weights = np.array(_axes(question).weights(TOOL_MM))
    return [
        _left(
            run,
            np.column_stack([one[at] for one in said]),
            np.column_stack([one[at] for one in spread]),
            weights,
        )
        for at, run in enumerate(judged.runs)
    ]


def _axes(question: Question) -> Any:
    rig = question.rig
    if isinstance(rig, FivePointRig):
        table: dict[str, Any] = {
            "kind": "five_point",
            "form": "rigid",
            "near_to_gauge_mm": rig.near_to_gauge_mm,
            "spacing_mm": rig.spacing_mm,
        }
        return geometry_from_fields(Fields(table, "rig"))
    return Direct({name: (entry.axis, entry.sign) for name, entry in rig.axes.items()})


def _left(run: PreparedRun, said: Array, spread: Array, weights: Array) -> RunLeft:
    rows = [row for row in grid_rows(run.time_s) if np.isfinite(run.targets[row]).all()]
    axes = {}
    for axis, row in zip("XYZ", weights, strict=True):
        if not row.any():
            continue
        drift, error = run.targets[rows] @ row, (run.targets - said)[rows] @ row
        half = WIDTH * np.abs(spread[rows]) @ np.abs(row)
        axes[axis] = AxisLeft(
            _rms(drift),
            _rms(error),
            float(np.mean(np.abs(error) <= half)),
            float(half.mean()),
            _rms(half) / WIDTH,
            0.0,
        )
    return RunLeft(run.name, None, axes, 0.0)


def _groups(run: PreparedRun, columns: Sequence[int]) -> list[Array]:
    rises = np.column_stack([_filled(run.inputs[:, column]) for column in columns])
    elapsed = np.diff(run.time_s, prepend=run.time_s[:1])
    return [rises, *(lagged(rises, elapsed, 60.0 * lag) for lag in LAGS_MIN)]


def _filled(values: Array) -> Array:
    there = np.flatnonzero(np.isfinite(values))
    return np.interp(np.arange(len(values)), there, values[there]) if len(there) else values * 0.0


def _rows(
    run: PreparedRun, groups: list[Array], target: int
) -> tuple[Array, list[Array], Array, float]:
    rows = np.flatnonzero(run.usable & np.isfinite(run.targets[:, target]))
    rows = rows[rows > 0][::EVERY]
    hours = (run.time_s[rows] - run.time_s[0]) / 3600.0
    return hours, [group[rows] for group in groups], run.targets[rows, target], 1.0


def _whitened(hours: Array, values: Array, walk: float, noise: float) -> tuple[Array, float]:
    covariance = walk**2 * np.minimum.outer(hours, hours) + noise**2 * np.eye(len(hours))
    root = np.linalg.cholesky(covariance)
    return np.linalg.solve(root, values), 2.0 * float(np.log(np.diag(root)).sum())


def _fitted(runs: Sequence[Any]) -> tuple[Any, ...]:
    count = len(runs[0][1])

    def cost(logs: Array, whole: bool = False) -> Any:
        scale, walk, noise = np.exp(logs[:count]), np.exp(logs[count]), np.exp(logs[count + 1])
        gram, cross, squares, determinant = 0.0, 0.0, 0.0, 0.0
        for hours, groups, measured, size in runs:
            both = np.column_stack([*(g * c for g, c in zip(groups, scale, strict=True)), measured])
            white, more = _whitened(hours, both, walk * size, noise)
            left, right = white[:, :-1], white[:, -1]
            gram, cross = gram + left.T @ left, cross + left.T @ right
            squares, determinant = squares + right @ right, determinant + more
        inside = gram + np.eye(len(gram))
        weights = np.linalg.solve(inside, cross)
        if whole:
            return scale, walk, noise, weights, np.linalg.inv(inside)
        usual = 0.5 * np.sum((logs[:count] - np.log(1.5)) ** 2)
        value = determinant + np.linalg.slogdet(inside)[1] + squares - cross @ weights
        return 0.5 * value + usual

    start = np.r_[np.full(count, np.log(1.5)), np.log(3.0), 0.0]
    bounds = [(-4.6, 3.4)] * count + [(-3.0, 3.9), (-3.0, 3.0)]
    found = minimize(cost, start, method="L-BFGS-B", bounds=bounds, options={"maxiter": 40})
    return cost(found.x, True)


def _robust(runs: Sequence[Any]) -> tuple[Any, ...]:
    model: tuple[Any, ...] = ()
    for _ in range(3):
        model = scale, walk, noise, weights, _ = _fitted(runs)
        again = []
        for hours, groups, measured, _ in runs:
            parts = np.hstack([g * c for g, c in zip(groups, scale, strict=True)])
            grid = np.arange(0.0, hours[-1] + 0.25, 0.5)
            steps = np.diff(np.interp(grid, hours, measured - parts @ weights), prepend=0.0)
            squares = np.sum(steps**2 / (walk**2 * 0.5 + noise**2))
            size = np.sqrt((FREEDOM + squares) / (FREEDOM + len(steps)))
            again.append((hours, groups, measured, float(np.clip(size, 0.6, 6.0))))
        runs = again
    return model


def _predicted(
    model: tuple[Any, ...], run: PreparedRun, groups: list[Array]
) -> tuple[Array, Array]:
    scale, walk, noise, weights, covariance = model
    parts = np.hstack([g * c for g, c in zip(groups, scale, strict=True)])
    hours = (run.time_s - run.time_s[0]) / 3600.0
    variance = np.einsum("ij,jk,ik->i", parts, covariance, parts) + walk**2 * hours + noise**2
    return parts @ weights, np.sqrt(variance)


def _rms(values: Array) -> float:
    return float(np.sqrt(np.mean(values**2)))
