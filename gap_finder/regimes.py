"""Where a model is wrong: residuals by channel, by the machine's regime, and by time."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from gap_finder.in_run import likely_starts
from gap_finder.linearise import modelled, simulate_at
from gap_finder.observations import INDEPENDENT_S, Observations
from measurement.spectrum import speed_spectrum
from plant_model.machine import Machine
from plant_model.parameters import FloatArray


@dataclass(frozen=True)
class Place:
    """A stretch of a run in which one channel is off.

    Attributes
    ----------
    run, channel, regime, unit : str
    start_s, end_s : float
        [s]
    rms : float
        Root mean square of model minus measurement [unit].
    tolerances : float
        The same in tolerances [1].
    """

    run: str
    channel: str
    start_s: float
    end_s: float
    regime: str
    rms: float
    unit: str
    tolerances: float


@dataclass(frozen=True)
class RunResiduals:
    """Model minus measurement of one run.

    Attributes
    ----------
    observed : Observations
    values : array, shape (K, C)
        [K, um]; NaN where nothing was measured.
    behind : dict of str to float
        By how much each lagging law is colder at the start than what it follows, by key [K].
    """

    observed: Observations
    values: FloatArray
    behind: Mapping[str, float] = field(default_factory=dict)


def residuals(machine: Machine, observed: Observations) -> RunResiduals:
    """Return model minus measurement of one run.

    Parameters
    ----------
    machine : Machine
    observed : Observations

    Returns
    -------
    RunResiduals
        Its values have the shape (K, C) [K, um]; NaN where nothing was measured.
    """
    shown = modelled(simulate_at(machine, observed), observed)[0]
    moved, behind = likely_starts(machine, observed, shown)
    return RunResiduals(observed, shown + moved - observed.values, behind)


def regimes(observed: Observations) -> list[tuple[float, float, str]]:
    """Return stretches of a run (start, end, regime), in order.

    After a change of speed it warms up or cools down for `INDEPENDENT_S`.

    Parameters
    ----------
    observed : Observations
        Of a run with or without a speed; an unknown speed counts as standstill.

    Returns
    -------
    list of (start, end, text)
        Start and end in seconds since the run's zero.
    """
    stretches = []
    before = 0.0
    for segment in speed_spectrum(observed.run):
        speed = 0.0 if np.isnan(segment.speed_rpm) else segment.speed_rpm
        at = f"at {speed:.0f} r/min" if speed else "standing"
        start = segment.start_s
        if speed != before:
            doing = "warming up" if speed > before else "cooling down"
            start = min(start + INDEPENDENT_S, segment.end_s)
            stretches.append((segment.start_s, start, f"{doing}, {at}"))
        if segment.end_s > start or speed == before:
            stretches.append((start, segment.end_s, f"steady, {at}" if speed else at))
        before = speed
    return stretches


def places(left: list[RunResiduals], most: int = 12) -> list[Place]:
    """Return where the model is off by more than the tolerance, worst first."""
    all_places = []
    for run in left:
        time = run.observed.time_s
        for start, end, regime in regimes(run.observed):
            rows = (time >= start) & (time <= end)
            for i, channel in enumerate(run.observed.channels):
                part = run.values[rows, i]
                part = part[np.isfinite(part)]
                if len(part) < 3:
                    continue
                rms = float(np.sqrt(np.mean(part**2)))
                ratio = rms / float(run.observed.tolerance[i])
                unit = run.observed.unit_of(i)
                all_places.append(
                    Place(run.observed.run.name, channel, start, end, regime, rms, unit, ratio)
                )
    ranked = sorted(all_places, key=lambda place: -place.tolerances)
    return [place for place in ranked if place.tolerances > 1.0][:most]


def gap_of(left: list[RunResiduals]) -> float:
    """Return the root mean square of residual over sensor noise, over all channels [1].

    Parameters
    ----------
    left : list of RunResiduals
        All with the same channels.
    """
    squares = np.concatenate([((run.values / run.observed.noise) ** 2).ravel() for run in left])
    return float(np.sqrt(np.nanmean(squares)))


def floor_of(left: list[RunResiduals]) -> list[RunResiduals]:
    """Return residuals as large as noise alone would leave, in place of each run's.

    Bins average several rows, but a displacement's zero is a single reading. Noise of what drives
    the model, and of the readings that it starts at, is not counted.

    Parameters
    ----------
    left : list of RunResiduals
        All with the same channels.
    """
    shares = []
    for run in left:
        rows = run.observed.run.frame.notna().to_numpy().sum() / run.observed.run.frame.shape[1]
        shares.append(len(run.observed.time_s) / max(rows, 1.0))
    share = np.mean(np.minimum(shares, 1.0)) + left[0].observed.lengths
    floor = left[0].observed.noise * np.sqrt(share)
    return [replace(r, values=np.where(np.isfinite(r.values), floor, np.nan)) for r in left]


def by_channel(left: list[RunResiduals]) -> dict[str, float]:
    """Return the root mean square residual of each channel [K, um], without unmeasured channels.

    Parameters
    ----------
    left : list of RunResiduals
        All with the same channels.
    """
    rms = np.sqrt(mean_squares([run.values for run in left])).tolist()
    pairs = zip(left[0].observed.channels, rms, strict=True)
    return {name: value for name, value in pairs if np.isfinite(value)}


def mean_squares(parts: Sequence[FloatArray]) -> FloatArray:
    """Return the mean square of each channel over all runs, shape (C,); NaN without a value."""
    values = np.concatenate(list(parts))
    count = np.isfinite(values).sum(axis=0)
    return np.asarray(
        np.where(count > 0, np.nansum(values**2, axis=0) / np.maximum(count, 1), np.nan)
    )


def range_of(values: FloatArray) -> float:
    """Return the range of what was measured in a series; 0 if nothing was."""
    measured = values[np.isfinite(values)]
    return float(np.ptp(measured)) if measured.size else 0.0
