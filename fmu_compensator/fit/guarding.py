"""The guard, the correction and the interval of a compensator file, from runs left out."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product
from typing import Any

import numpy as np

from fmu_compensator.fit.careful import CarefulModel
from fmu_compensator.fit.conditions import UNLIKE
from fmu_compensator.fit.data import Prepared
from fmu_compensator.fit.intervals import (
    FRESH_H,
    Interval,
    Residuals,
    axis_drift,
    conformal,
)
from fmu_compensator.fit.training import Array, TrainingRun, sensor_noise
from fmu_compensator.fit.unseen import (
    DEVIATIONS,
    Unseen,
    known_novelty,
    leash_of,
    residuals_of,
)
from fmu_compensator.runtime.geometry import AXES, Direct, Geometry

MEMORIES_H = (0.25, 0.5, 1.0, 2.0, 4.0, 8.0, 16.0)
"""How long an error may stay alike [h]."""
FAST_SHARES = (0.0, 0.02, 0.05, 0.1, 0.2, 0.4)
"""How much of an error's variance may come and go between two samples [1]: no probe helps there,
and a correction that took it for lasting would carry it on."""
PACE_H = 0.25
"""Errors this far apart are looked at for both [h]."""
PROBED_H = 1.0
"""They are judged with a probe as often as this [h]."""
UNMEASURED_MEMORY_H = 1.0
"""Where no run could be left out [h]."""


@dataclass(frozen=True)
class Guarding:
    """What goes into the file, beside the error model.

    Attributes
    ----------
    guard, correction : dict
        The file's tables.
    interval : dict or None
        Likewise; None where no run could be left out.
    leash : array (m,)
        Of the guard [um, urad].
    targets : Interval or None
        The interval of the targets, of which the correction is made.
    by_run : list of dict
        Of each like run left out: ``run``, ``miss``, the root mean square of its error at the
        longest tool over the half width along X, Y, Z [1], null where not measured, and ``new``,
        the share of its samples beyond the known novelty [1].
    """

    guard: dict[str, Any]
    correction: dict[str, Any]
    interval: dict[str, Any] | None
    leash: Array
    targets: Interval | None
    by_run: list[dict[str, Any]]


def guarding(
    prepared: Prepared,
    chosen: Sequence[int],
    input_form: str,
    predicted: Sequence[Array],
    records: Sequence[Unseen],
    geometry: Geometry,
    tool_length_mm: Sequence[float],
) -> Guarding:
    """Return guard, correction and interval.

    Parameters
    ----------
    prepared : Prepared
        All training runs.
    chosen : sequence of int
        The error model's sensors.
    input_form : {"rise", "absolute", "level"}
        Its input form.
    predicted : sequence of array (n, m)
        What the error model predicts for each run's ``history`` rows, fitted to all of them.
    records : sequence of Unseen
        Runs left out; may be empty: then training itself says how far the models differ and how
        new its inputs are, and there is no interval.
    geometry : Geometry
        From targets to drift.
    tool_length_mm : sequence of float
        Shortest and longest tool.
    """
    careful = CarefulModel.fit(prepared.runs, chosen, input_form)
    rows = [run.history(chosen) for run in prepared.runs]
    usual = usual_drift(rows, geometry, tool_length_mm)
    noise = sensor_noise(rows, len(prepared.targets))
    if records:
        leash, known = leash_of(records), known_novelty(records)
        residuals = residuals_of(records, leash)
        interval = conformal(residuals)
        at_tip = tool_tip_residuals(records, leash, geometry, tool_length_mm)
        tip = conformal(at_tip)
        by_run = [
            _by_run(one, missed, tip, known, geometry)
            for one, missed in zip(records, at_tip, strict=True)
            if not missed.unlike
        ]
        spread = interval.scale / DEVIATIONS
        memory_h, fast = error_memory(residuals, interval)
        noise = np.maximum(noise, fast * spread**2)
        grown = [_mean_square_growth(tip, one) for one in residuals]
        per_novelty = tip.per_novelty * (tip.scale / DEVIATIONS) ** 2 * float(np.mean(grown))
        table: dict[str, Any] | None = _interval_table(tip, geometry)
    else:
        own = [careful.predict(run, chosen) for run in prepared.runs]
        apart = [np.abs(main - safe) for main, (safe, _) in zip(predicted, own, strict=True)]
        leash = np.max([one.max(axis=0) for one in apart if len(one)], axis=0)
        known = max(float(novelty.max()) for _, novelty in own if len(novelty))
        interval, table, memory_h, fast = None, None, UNMEASURED_MEMORY_H, 0.0
        by_run = []
        spread = np.sqrt(careful.posterior.noise)
        per_novelty = _axis_noise(careful, rows, geometry, tool_length_mm)
    fade = _listed(per_novelty / np.maximum(usual, 1e-12), geometry)
    guard = {
        **careful.table(),
        "known": _plain(known),
        "leash": [_plain(value) for value in leash],
        "fade_shortest": fade[0],
        "fade_longest": fade[1],
    }
    correction = {
        "memory_s": 3600.0 * memory_h,
        "spread": [_plain(max(value, 1e-3)) for value in spread],
        "noise": [_plain(value) for value in noise],
        "fast": fast,
    }
    return Guarding(guard, correction, table, leash, interval, by_run)


def _by_run(
    record: Unseen, missed: Residuals, tip: Interval, known: float, geometry: Geometry
) -> dict[str, Any]:
    """Return what a run left out showed, for whoever compares later runs with it."""
    scaled = missed.values / np.maximum(tip.half_width(missed), 1e-9)
    miss = np.sqrt(np.mean(scaled**2, axis=0))
    return {
        "run": record.run,
        "miss": _listed(miss, geometry)[1],
        "new": float(np.mean(record.novelty > known)),
    }


def tool_tip_residuals(
    records: Sequence[Unseen],
    leash: Array | None,
    geometry: Geometry,
    tool_length_mm: Sequence[float],
) -> list[Residuals]:
    """Return what is missed at the tool tip: X, Y, Z at the shortest tool, then at the longest.

    In between the run time takes the straight line; the spread of a sum that is linear in the
    length lies on or below it.

    Parameters
    ----------
    records : sequence of Unseen
        Runs left out.
    leash : array (m,), optional
        On which the prediction is [um, urad].
    geometry : Geometry
        From targets to drift. Errors of tilt and radial drift go together, so their widths must
        not be added: it is the drift itself that the interval is learnt from.
    tool_length_mm : sequence of float
        Shortest and longest tool.
    """
    return [
        Residuals(
            one.hours,
            np.hstack(
                [
                    axis_drift(geometry, one.measured, length)
                    - axis_drift(geometry, one.held(leash), length)
                    for length in tool_length_mm
                ]
            ),
            one.novelty,
            one.fold.kind == UNLIKE,
        )
        for one in records
    ]


def error_memory(residuals: Sequence[Residuals], interval: Interval) -> tuple[float, float]:
    """Return how long errors of unseen runs stay alike [h], and which share is fast [1].

    Of `MEMORIES_H` and `FAST_SHARES` those with which the correction, given a measurement every
    `PROBED_H`, foretells the errors in between best: by the logarithm of their likelihood, each run
    counting as one.
    """
    series = [_paced(one, interval) for one in residuals]
    size = np.sqrt(np.mean([np.mean(values**2, axis=0) for _, values in series], axis=0))
    scaled = [(hours, values / np.maximum(size, 1e-6)) for hours, values in series]
    scores = {
        (memory, share): sum(_foretold(*one, memory, share) for one in scaled)
        for memory, share in product(MEMORIES_H, FAST_SHARES)
    }
    return min(scores, key=lambda pair: scores[pair])


def _foretold(hours: Array, values: Array, memory_h: float, share: float) -> float:
    """Return minus the mean logarithm of the likelihood of a run's errors between its probes."""
    noise = max(share, 1e-3)
    bias, doubt, total, count = np.zeros(values.shape[1]), 1.0, 0.0, 0
    probed_h = -np.inf
    for place in range(len(hours)):
        if place:
            kept = float(np.exp(-(hours[place] - hours[place - 1]) / memory_h))
            bias, doubt = bias * kept, 1.0 - (1.0 - doubt) * kept**2
        variance = doubt + noise
        missed = values[place] - bias
        if np.isfinite(probed_h):
            total += float(np.mean(missed**2 / variance + np.log(variance)))
            count += 1
        if hours[place] - probed_h >= PROBED_H - 0.5 * PACE_H:
            gain = doubt / variance
            bias, doubt, probed_h = bias + gain * missed, (1.0 - gain) * doubt, hours[place]
    return total / max(count, 1)


def likeliest_memory(series: Sequence[tuple[Array, Array]]) -> float:
    """Return which of `MEMORIES_H` explains series best: times [h] and values, shape (n, m) [1]."""
    best, found = -np.inf, MEMORIES_H[0]
    for memory in MEMORIES_H:
        total = 0.0
        for hours, values in series:
            kept = np.exp(-np.diff(hours) / memory)[:, None]
            step = values[1:] - kept * values[:-1]
            variance = np.maximum(1.0 - kept**2, 1e-6)
            size = np.maximum(np.mean(values**2, axis=0), 1e-6)
            total -= float(np.mean(step**2 / variance / size + np.log(variance)))
        if total > best:
            best, found = total, memory
    return found


def rows_apart(hours: Array) -> list[int]:
    """Return rows that are at least `PACE_H` apart."""
    kept = [0]
    for row, hour in enumerate(hours):
        if hour - hours[kept[-1]] >= PACE_H:
            kept.append(row)
    return kept


def _paced(residuals: Residuals, interval: Interval) -> tuple[Array, Array]:
    kept = rows_apart(residuals.hours)
    scale = interval.half_width(residuals)[kept] / DEVIATIONS
    if len(kept) < 2:
        return np.array([0.0, 1.0]), np.zeros((2, residuals.values.shape[1]))
    return residuals.hours[kept], residuals.values[kept] / np.maximum(scale, 1e-9)


def _mean_square_growth(interval: Interval, residuals: Residuals) -> float:
    grown = (FRESH_H + np.minimum(residuals.hours, interval.longest_h)) ** interval.power
    return float(np.mean(grown**2))


def usual_drift(
    rows: Sequence[TrainingRun], geometry: Geometry, tool_length_mm: Sequence[float]
) -> Array:
    """Return the mean square drift along X, Y, Z at either tool, shape (6,) [um^2]."""
    known = [run.targets[run.known] for run in rows if run.known.any()]
    thinned = [one[:: max(len(one) // 100, 1)] for one in known]
    drift = [
        np.hstack([axis_drift(geometry, one, length) for length in tool_length_mm])
        for one in thinned
    ]
    return np.asarray(np.mean([np.mean(one**2, axis=0) for one in drift], axis=0))


def _axis_noise(
    careful: CarefulModel,
    rows: Sequence[TrainingRun],
    geometry: Geometry,
    tool_length_mm: Sequence[float],
) -> Array:
    """Return the variance that a unit of novelty brings along X, Y, Z at either tool [um^2]."""
    targets = np.diag(np.sqrt(careful.posterior.noise))
    parts = [
        np.sum(axis_drift(geometry, targets, length) ** 2, axis=0) for length in tool_length_mm
    ]
    return np.hstack(parts)


def _interval_table(interval: Interval, geometry: Geometry) -> dict[str, Any]:
    shortest, longest = _listed(interval.scale, geometry)
    return {
        "coverage": interval.coverage,
        "power": interval.power,
        "fresh_h": FRESH_H,
        "longest_h": _plain(interval.longest_h),
        "per_novelty": interval.per_novelty,
        "shortest_tool_um": shortest,
        "longest_tool_um": longest,
    }


def _listed(values: Array, geometry: Geometry) -> list[list[float | None]]:
    """Return numbers for X, Y, Z at the shortest and the longest tool; None where unmeasured."""
    measured = geometry.axes if isinstance(geometry, Direct) else AXES
    return [
        [_plain(value) if axis in measured else None for axis, value in zip(AXES, row, strict=True)]
        for row in values.reshape(2, 3).tolist()
    ]


def _plain(value: float) -> float:
    return float(f"{value:.6g}")
