"""Ways to break a sensor in a run, and healthy oddities that are no faults."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from measurement.faults.series import lengths_of
from measurement.runs import FloatArray, Run

Span = tuple[float, float]
Broken = tuple[FloatArray, Span]


@dataclass(frozen=True)
class Breakage:
    """A way to break a sensor.

    Attributes
    ----------
    name : str
        As the tables say it.
    unit : {"degC", "um"}
        Of the sensors that it is for.
    change : callable
        Takes time [s], readings and a random generator; returns new readings and the span [s].
    """

    name: str
    unit: str
    change: Callable[[FloatArray, FloatArray, np.random.Generator], Broken]


def planted(run: Run, column: str, how: Breakage, rng: np.random.Generator) -> tuple[Run, Span]:
    """Return the run with one sensor broken, and when it is."""
    values, span = how.change(run.time_s, run.frame[column].to_numpy(float).copy(), rng)
    return replace(run, frame=run.frame.assign(**{column: values}), faults=None), span


def _offset(size: float) -> Callable[..., Broken]:
    def change(time: FloatArray, values: FloatArray, rng: np.random.Generator) -> Broken:
        return values + size, (time[0], time[-1])

    return change


def _frozen(minutes: float) -> Callable[..., Broken]:
    """Freeze for so long, and recover where the run is longer."""

    def change(time: FloatArray, values: FloatArray, rng: np.random.Generator) -> Broken:
        length = min(60.0 * minutes, 0.85 * (time[-1] - time[0]))
        start = rng.uniform(time[0], time[-1] - length)
        rows = (time >= start) & (time <= start + length)
        values[rows] = values[rows][np.isfinite(values[rows])][0]
        return values, (float(time[rows][0]), float(time[rows][-1]))

    return change


def _constant(level: float, share: float) -> Callable[..., Broken]:
    """Drop to a constant level after a share of the run."""

    def change(time: FloatArray, values: FloatArray, rng: np.random.Generator) -> Broken:
        start = time[0] + share * (time[-1] - time[0])
        values[time >= start] = level
        return values, (float(time[time >= start][0]), float(time[-1]))

    return change


def _spike(size: float, *, first: bool) -> Callable[..., Broken]:
    def change(time: FloatArray, values: FloatArray, rng: np.random.Generator) -> Broken:
        at = 0 if first else int(rng.integers(6, len(time) - 6))
        values[at] += size
        return values, (float(time[at]), float(time[at]))

    return change


def _step(size: float, *, back: bool = False) -> Callable[..., Broken]:
    def change(time: FloatArray, values: FloatArray, rng: np.random.Generator) -> Broken:
        first, last = np.sort(rng.integers(10, len(time) - 10, 2))
        rows = np.arange(len(time)) >= first
        if back:
            rows &= np.arange(len(time)) <= max(last, first + 5)
        values[rows] += size
        return values, (float(time[rows][0]), float(time[rows][-1]))

    return change


def _runaway(size: float, minutes: float) -> Callable[..., Broken]:
    def change(time: FloatArray, values: FloatArray, rng: np.random.Generator) -> Broken:
        start = rng.uniform(time[0] + 1800.0, time[-1] - 3600.0)
        values += np.interp(time, [start, start + 60.0 * minutes], [0.0, size])
        return values, (float(time[time >= start][0]), float(time[-1]))

    return change


def _saturated(share: float) -> Callable[..., Broken]:
    """Cut off the outermost share of the range."""

    def change(time: FloatArray, values: FloatArray, rng: np.random.Generator) -> Broken:
        low, high = np.nanmin(values), np.nanmax(values)
        up = abs(high - values[0]) >= abs(low - values[0])
        end = high - share * (high - low) if up else low + share * (high - low)
        rows = values > end if up else values < end
        values[rows] = end
        return values, (float(time[rows][0]), float(time[rows][-1]))

    return change


BREAKAGES = (
    *(Breakage(f"level {size:+g} K", "degC", _offset(size)) for size in (10.0, 20.0, 30.0, -30.0)),
    *(Breakage(f"frozen {length:g} min", "degC", _frozen(length)) for length in (60, 120, 300)),
    Breakage("dead at 0 from the middle on", "degC", _constant(0.0, 0.5)),
    Breakage("dead at 0 from the start on", "degC", _constant(0.0, 0.0)),
    *(Breakage(f"first reading {s:+g} K", "degC", _spike(s, first=True)) for s in (5.0, 15.0)),
    *(Breakage(f"one reading {s:+g} K", "degC", _spike(s, first=False)) for s in (5.0, 15.0)),
    *(Breakage(f"step {s:+g} K", "degC", _step(s)) for s in (4.0, 8.0, 20.0)),
    Breakage("step +20 K and back", "degC", _step(20.0, back=True)),
    *(Breakage(f"runs away {s:+g} K in 20 min", "degC", _runaway(s, 20.0)) for s in (10.0, 30.0)),
    *(Breakage(f"first reading {s:+g} um", "um", _spike(s, first=True)) for s in (10.0, 50.0)),
    *(Breakage(f"one reading {s:+g} um", "um", _spike(s, first=False)) for s in (10.0, 50.0)),
    *(Breakage(f"step {s:+g} um", "um", _step(s)) for s in (10.0, 30.0, 60.0)),
    *(Breakage(f"frozen {length:g} min (um)", "um", _frozen(length)) for length in (60, 120)),
    Breakage("end of the range at 70 %", "um", _saturated(0.3)),
)


Odd = Callable[[Run, str, np.random.Generator], Run]


def _hot(run: Run, column: str, rng: np.random.Generator) -> Run:
    """Add heat that follows the others' mean rise, smoothed, up to 25 K more."""
    rises = run.frame[run.temperatures].ffill().bfill().to_numpy(float)
    mean = (rises - rises[0]).mean(axis=1)
    rows = _rows_in(run, 1200.0)
    padded = np.concatenate([np.full(rows, mean[0]), mean])
    smooth = np.convolve(padded, np.ones(rows) / rows, "full")[rows : rows + len(mean)]
    smooth -= smooth[0]
    size = 25.0 / max(float(np.abs(smooth).max()), 0.5)
    return _with(run, column, run.frame[column].to_numpy(float) + size * smooth)


def _rare(run: Run, column: str, rng: np.random.Generator) -> Run:
    values = run.frame[column].to_numpy(float)
    every = _rows_in(run, 900.0)
    return _with(run, column, np.where(np.arange(len(values)) % every, np.nan, values))


def _held(run: Run, column: str, rng: np.random.Generator) -> Run:
    values = run.frame[column].ffill().bfill().to_numpy(float)
    every = _rows_in(run, 900.0)
    return _with(run, column, values[np.arange(len(values)) // every * every])


def _coarse(run: Run, column: str, rng: np.random.Generator) -> Run:
    return _with(run, column, np.round(run.frame[column].to_numpy(float)))


def _unmoved(run: Run, column: str, rng: np.random.Generator) -> Run:
    """Let the machine stand: every reading as at the start, with the resolution's noise."""
    names = [*run.temperatures, *lengths_of(run)]
    frame = run.frame.copy()
    for name in names:
        frame[name] = frame[name].bfill().iloc[0] + 0.1 * (rng.random(len(frame)) < 0.02)
    for name in set(map(str, frame.columns[1:])) - set(names):
        frame[name] = 0.0
    return replace(run, frame=frame, faults=None)


def _warm(run: Run, column: str, rng: np.random.Generator) -> Run:
    """Begin a third later: a record that starts on a warm machine."""
    return replace(run, frame=run.frame.iloc[len(run.frame) // 3 :], faults=None)


def _no_drive(run: Run, column: str, rng: np.random.Generator) -> Run:
    """Drop the commands: nobody recorded when something was switched."""
    names = [*run.temperatures, *lengths_of(run)]
    return replace(run, frame=run.frame[["time_s", *names]], faults=None)


def _with(run: Run, column: str, values: FloatArray) -> Run:
    return replace(run, frame=run.frame.assign(**{column: values}), faults=None)


def _rows_in(run: Run, span_s: float) -> int:
    return max(2, round(span_s / float(np.median(np.diff(run.time_s)))))


ODDITIES: dict[str, Odd] = {
    "one part 25 K hot": _hot,
    "one sensor read every 15 min, else empty": _rare,
    "one sensor read every 15 min, else held": _held,
    "one sensor read in whole K": _coarse,
    "the machine stands": _unmoved,
    "recorded from warm on": _warm,
    "no command recorded": _no_drive,
}
"""What must raise no alarm, by name."""
