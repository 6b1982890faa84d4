"""Finds runs whose numbers are far more likely in another unit than the declared one.

Each quantity is log-normal about what machine tools show (`USUAL`); temperatures at rest are normal
about that of a hall. A unit is doubted if another one makes the numbers so much more likely that
this outweighs how rarely units are wrong (`WRONG`).
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from typing import NamedTuple

import numpy as np

from measurement.resampling import WARMS_K, WRONG, FloatArray, recorded_steps
from measurement.rig import axis_of
from measurement.runs import TIME, Run
from measurement.units import UM_PER_MM, split_column


class Usual(NamedTuple):
    """Distribution of a quantity on machine tools: log-normal, or normal if `spread` has a unit."""

    median: float
    spread: float

    def log_likelihood(self, value: float) -> float:
        """Return the log-likelihood of a value, up to a constant."""
        return -0.5 * (math.log(value / self.median) / self.spread) ** 2


USUAL = {
    "half of the warming [s]": Usual(3600.0, 1.0),
    "run [s]": Usual(6.0 * 3600.0, 1.2),
    "drift for each kelvin [um]": Usual(5.0, 1.2),
    "top speed [r/min]": Usual(5000.0, 1.1),
}
"""Median, and standard deviation of the logarithm [1]. Set on 30 runs of a lathe (half of the
warming within 0.4 to 1.6 h, 1 to 16 um/K, 1000 and 2000 r/min), 50 h of an electric spindle and
simulated runs of both shipped machines (up to 24 um/K, 14,000 r/min), and then widened, because two
machines are few."""
HALL_C = Usual(21.0, 7.0)
"""Coolest reading in a log: a hall's temperature [degC], with its standard deviation [K]."""
ASTRAY_PER_K = WRONG / 100.0
"""Density of a thermometer with a wrong level [1/K]: one in a hundred, anywhere in 100 K."""

TIMES = {
    60.0: ("minutes taken for seconds", "min"),
    3600.0: ("hours taken for seconds", "h"),
    1.0 / 60.0: ("seconds taken for minutes", "s"),
    1e-3: ("milliseconds taken for seconds", "ms"),
}
LENGTHS = {
    1000.0: ("millimetres taken for micrometres", "mm"),
    1e-3: ("micrometres taken for millimetres", "um"),
}
SPEEDS = {1000.0: ("thousands of r/min", "krpm"), 60.0: ("turns a second", "Hz")}
TEMPERATURES = {
    "K": ("kelvin", 1.0, -273.15),
    "degF": ("Fahrenheit", 5.0 / 9.0, -160.0 / 9.0),
}
TENTHS = {"0.1 degC": ("tenths of a degree", 0.1, 0.0)}
"""The usual mistakes: which unit was taken for which, and the correct one. A control stores tenths
as whole numbers."""


def unlikely_units(runs: Sequence[Run], warm: Sequence[FloatArray]) -> list[tuple[str, str]]:
    """Return columns whose unit is doubtful, each with a text that names the more likely one.

    *warm* is each run's `warming` [K].
    """
    return [
        *_temperatures(runs),
        *_clock(runs, warm),
        *_displacements(runs, warm),
        *_lengths(runs, warm),
        *_speeds(runs, warm),
    ]


def likelier(
    values: Sequence[tuple[str, float]], readings: Mapping[float, tuple[str, str]]
) -> tuple[str, str] | None:
    """Return the reading that is far more likely than the declared one, or None.

    Parameters
    ----------
    values : sequence of (str, float)
        Quantities of `USUAL` and their values in the declared unit, each proportional to the unit.
    readings : mapping of float to (str, str)
        Other units by their factor.
    """

    def log_likelihood(factor: float) -> float:
        return sum(USUAL[what].log_likelihood(factor * value) for what, value in values)

    said = log_likelihood(1.0) + math.log1p(-WRONG)
    best = max(readings, key=log_likelihood)
    other = log_likelihood(best) + math.log(WRONG / len(readings))
    return readings[best] if other > said else None


def _clock(runs: Sequence[Run], warm: Sequence[FloatArray]) -> Iterator[tuple[str, str]]:
    doubted = []
    for run, rise in zip(runs, warm, strict=True):
        time = np.append(0.0, np.cumsum(recorded_steps(run.time_s)))
        half, long = _half(time, rise), float(time[-1])
        values = [("half of the warming [s]", half), ("run [s]", long)]
        if half and (other := likelier(values, TIMES)):
            text = f"by this clock the machine makes half of its warming within {_time(half)}"
            text = f"{text} in a run of {_time(long)}: {other[0]}? then its unit is {other[1]}"
            doubted.append((run.name, text))
    yield from _told(TIME, doubted, len(runs))


def _told(column: str, doubted: Sequence[tuple[str, str]], runs: int) -> Iterator[tuple[str, str]]:
    """Give the first doubt about a column, and the runs that share it unless all do."""
    if doubted:
        names = ", ".join(name for name, _ in doubted)
        where = "" if len(doubted) == runs else f" (in {names})"
        yield column, doubted[0][1] + where


def _half(time: FloatArray, rise: FloatArray) -> float:
    """Return the shortest time in which a run warms by half of its total [s]; 0 if it does not."""
    wanted = 0.5 * float(np.ptp(rise))
    if 2.0 * wanted < WARMS_K:
        return 0.0
    shortest = math.inf
    for start in range(0, len(rise), max(1, len(rise) // 50)):
        beyond = np.flatnonzero(np.abs(rise[start:] - rise[start]) >= wanted)
        if beyond.size and beyond[0] >= 3:  # a leap between two rows is a fault of a sensor
            shortest = min(shortest, float(time[start + beyond[0]] - time[start]))
    return shortest if math.isfinite(shortest) else 0.0


def _displacements(runs: Sequence[Run], warm: Sequence[FloatArray]) -> Iterator[tuple[str, str]]:
    usual = USUAL["drift for each kelvin [um]"].median
    for name in runs[0].displacements:
        doubted = []
        for run, span, kelvin in _spans(runs, warm, name):
            ratio = span / max(kelvin, WARMS_K)
            # A machine that does not warm may be at rest; it cannot move by metres.
            if span == 0.0 or (kelvin < WARMS_K and ratio < usual):
                continue
            if other := likelier([("drift for each kelvin [um]", ratio)], LENGTHS):
                text = f"moves by {span:.2g} um while the machine warms by {kelvin:.0f} K"
                text = f"{text}: {other[0]}? then its unit is {other[1]}"
                doubted.append((run.name, text))
        yield from _told(name, doubted, len(runs))


def _lengths(runs: Sequence[Run], warm: Sequence[FloatArray]) -> Iterator[tuple[str, str]]:
    """Doubt lengths in mm that move like the drift of an axis without a displacement.

    Such a name may also belong to the position of an axis, which moves by much more.
    """
    measured = {_axis(name) for name in runs[0].displacements}
    for name in runs[0].of_unit("mm"):
        if _axis(name) in {None, *measured}:
            continue
        doubted = []
        for run, span, kelvin in _spans(runs, warm, name):
            drift = UM_PER_MM * span / max(kelvin, WARMS_K)
            usual = USUAL["drift for each kelvin [um]"]
            if drift > 0.0 and usual.log_likelihood(drift) > math.log(WRONG):
                text = f"moves by {span:.2g} mm while the machine warms by {kelvin:.0f} K: a drift?"
                doubted.append((run.name, f"{text} only one in um is used: convert it"))
        yield from _told(name, doubted, len(runs))


def _axis(name: str) -> str | None:
    axis = axis_of(split_column(name)[0])
    return axis[0] if axis else None


def _spans(
    runs: Sequence[Run], warm: Sequence[FloatArray], name: str
) -> Iterator[tuple[Run, float, float]]:
    """Give the span of a column in each run that has it, and of the warming [K]."""
    for run, rise in zip(runs, warm, strict=True):
        if name in run.frame and run.frame[name].notna().any():
            ends = np.quantile(run.frame[name].dropna(), (0.02, 0.98))  # no single reading decides
            yield run, float(np.ptp(ends)), float(np.ptp(rise))


def _speeds(runs: Sequence[Run], warm: Sequence[FloatArray]) -> Iterator[tuple[str, str]]:
    for name in runs[0].of_unit("rpm"):
        doubted = []
        for run, rise in zip(runs, warm, strict=True):
            top = float(run.frame[name].abs().max()) if name in run.frame else 0.0
            kelvin = float(np.ptp(rise))
            if not top > 0.0 or kelvin < WARMS_K:
                continue
            if other := likelier([("top speed [r/min]", top)], SPEEDS):
                text = f"is at most {top:g} r/min while the machine warms by {kelvin:.0f} K"
                doubted.append((run.name, f"{text}: {other[0]}? then its unit is {other[1]}"))
        yield from _told(name, doubted, len(runs))


def _temperatures(runs: Sequence[Run]) -> Iterator[tuple[str, str]]:
    """Doubt thermometers that are more likely in kelvin or Fahrenheit, all together or one by one.

    The coolest readings scatter about the hall's temperature; each is as declared, or wrong alone.
    """
    coolest, whole = {}, []
    for name in runs[0].temperatures:
        values = np.concatenate([run.frame[name].dropna() for run in runs if name in run.frame])
        if values.size:
            coolest[name] = float(np.quantile(values, 0.02))  # no single reading decides
            whole.append(not (values % 1.0).any())
    if not coolest:
        return
    others = TEMPERATURES | TENTHS if any(whole) else TEMPERATURES
    names, said = list(coolest), np.array(list(coolest.values()))
    read = np.array([said] + [scale * said + zero for _, scale, zero in others.values()])
    halls = np.unique(read.round(1))
    units = ["degC", *others]
    best, chosen = -math.inf, np.zeros(len(names), dtype=int)
    for common in range(len(units)):
        odds = np.full((len(units), 1), math.log(WRONG / len(others)))
        odds[common] = math.log1p(-WRONG)
        prior = math.log(WRONG / len(others)) if common else math.log1p(-WRONG)
        for hall in halls.tolist():
            # Thermometers of a machine that has not warmed differ by no more than this.
            near = np.exp(-np.abs(read - hall) / WARMS_K) / (2.0 * WARMS_K)
            scores = np.log(near + ASTRAY_PER_K) + odds
            if any(whole):
                scores[-1, ~np.array(whole)] = -math.inf
            total = scores.max(axis=0).sum() - 0.5 * ((hall - HALL_C.median) / HALL_C.spread) ** 2
            if total + prior > best:
                best, chosen = total + prior, scores.argmax(axis=0)
    for name, unit, value in zip(names, chosen.tolist(), said.tolist(), strict=True):
        if unit:
            called = others[units[unit]][0]
            text = f"never reads less than {value:.4g} degC: {called}?"
            yield name, f"{text} then its unit is {units[unit]}"


def _time(seconds: float) -> str:
    if seconds >= 3600.0:
        return f"{seconds / 3600.0:.2g} h"
    return f"{seconds / 60.0:.2g} min" if seconds >= 60.0 else f"{seconds:.2g} s"
