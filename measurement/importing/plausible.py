"""What the numbers of a log contradict: a unit, the clock's unit, a sign."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pandas as pd

from measurement.importing.signs import WARMS_K, doubted_signs
from measurement.resampling import FloatArray
from measurement.runs import TIME, Run

KELVIN_C = 200.0
"""No thermometer on a spindle reads as much in the middle of a log [degC]; 20 degC is 293 K."""
COLDEST_C = 45.0
"""The coolest reading of a log is lower, unless it is in Fahrenheit [degC]: 10 degC is 50 degF."""
APART_K = 25.0
"""A thermometer that begins so far from the others [K], and with them as Fahrenheit within ..."""
TOGETHER_K = 4.0
"""... this [K], is in Fahrenheit."""
STILL_UM = 0.5
"""Less displacement than this [um] beside `WARMS_K` of warming is displacement in millimetres."""
FAR_UM = 5000.0
"""More displacement than this within a log is micrometres called millimetres [um]."""
FASTEST_K_PER_S = 0.02
"""The mean of all thermometers does not warm faster [K/s]. In measured runs of a lathe it warmed by
0.0011 K/s at most; sixty times that, minutes called seconds, is 0.03 to 0.07. The minutes of a slow
machine stay below and pass unnoticed."""
SLOWEST_RPM = 120.0
"""A spindle that warms by `WARMS_K` turns faster than this [r/min]."""


def doubts(runs: Sequence[Run]) -> list[tuple[str, str]]:
    """Return what looks wrong with the units, the clock or a sign in runs of one log.

    Parameters
    ----------
    runs : sequence of Run

    Returns
    -------
    list of (column, text)
        One for each column and kind of doubt; the text says what to change.
    """
    if not runs:
        return []
    whole = pd.concat([run.frame for run in runs], ignore_index=True)
    warming = [_warming(run) for run in runs]
    return [
        *_temperatures(whole, runs),
        *_clock(runs),
        *_displacements(whole, warming),
        *_speeds(whole, warming),
        *doubted_signs(runs, warming),
    ]


def _warming(run: Run) -> FloatArray:
    """Return the mean rise of a run's thermometers over its rows [K]; zeros without any."""
    if not run.temperatures:
        return np.zeros(len(run.frame))
    filled = run.frame[run.temperatures].interpolate(limit_direction="both").to_numpy()
    filled = filled[:, np.isfinite(filled).all(axis=0)]
    return np.asarray((filled - filled[0]).mean(axis=1) if filled.size else np.zeros(len(filled)))


def _temperatures(whole: pd.DataFrame, runs: Sequence[Run]) -> list[tuple[str, str]]:
    names = [name for name in runs[0].temperatures if whole[name].notna().any()]
    found = []
    kelvin = {name for name in names if whole[name].median() > KELVIN_C}
    for name in sorted(kelvin):
        span = f"{whole[name].min():g} to {whole[name].max():g}"
        found.append((name, f"reads {span} degC: kelvin? then its unit is K"))
    left = [name for name in names if name not in kelvin]
    if not left:
        return found
    if min(whole[name].min() for name in left) > COLDEST_C:
        coolest = min(whole[name].min() for name in left)
        text = f"never reads less than {coolest:g} degC, nor does any other: Fahrenheit? unit degF"
        return found + [(name, text) for name in left]
    starts = {name: float(runs[0].frame[name].dropna().iloc[:1].mean()) for name in left}
    starts = {name: start for name, start in starts.items() if start == start}
    lowest = min(starts.values(), default=0.0)
    cool = float(np.median([start for start in starts.values() if start - lowest < TOGETHER_K]))
    for name, start in starts.items():
        if start - cool > APART_K and abs((start - 32.0) / 1.8 - cool) < TOGETHER_K:
            text = f"begins at {start:g} degC and others near {cool:g}: Fahrenheit? unit degF"
            found.append((name, text))
    return found


def _clock(runs: Sequence[Run]) -> list[tuple[str, str]]:
    """Doubt a clock by which the machine warms faster than any does."""
    fastest = 0.0
    for run in runs:
        warm, time = _warming(run), run.time_s
        # Over a rise of a few kelvin, so that neither noise nor a resolution counts.
        for start in range(0, len(warm), max(1, len(warm) // 50)):
            beyond = np.flatnonzero(np.abs(warm[start:] - warm[start]) >= WARMS_K)
            if beyond.size:
                end = start + int(beyond[0])
                rate = abs(warm[end] - warm[start]) / (time[end] - time[start])
                if end - start >= 3:  # a leap between two rows is a fault of a sensor
                    fastest = max(fastest, float(rate))
    if fastest < FASTEST_K_PER_S:
        return []
    text = f"by this clock the machine warms by {60 * fastest:.0f} K/min: minutes called seconds?"
    return [(TIME, f"{text} then its unit is min")]


def _displacements(whole: pd.DataFrame, warming: Sequence[FloatArray]) -> list[tuple[str, str]]:
    most = max(float(np.ptp(part)) for part in warming)
    found = []
    for name in [str(name) for name in whole.columns if str(name).endswith("_um")]:
        values = whole[name].dropna()
        span = float(np.ptp(values)) if len(values) else 0.0
        if 0.0 < span < STILL_UM and most > WARMS_K:
            text = f"moves by {span:.2g} um while the machine warms by {most:.0f} K"
            found.append((name, f"{text}: millimetres? then its unit is mm"))
        elif span > FAR_UM:
            text = f"moves by {span:.0f} um: micrometres called millimetres?"
            found.append((name, f"{text} then its unit is um"))
    return found


def _speeds(whole: pd.DataFrame, warming: Sequence[FloatArray]) -> list[tuple[str, str]]:
    most = max(float(np.ptp(part)) for part in warming)
    found = []
    for name in [str(name) for name in whole.columns if str(name).endswith("_rpm")]:
        top = float(whole[name].abs().max())
        if 0.0 < top < SLOWEST_RPM and most > WARMS_K:
            text = f"is at most {top:g} r/min while the machine warms by {most:.0f} K: thousands"
            found.append((name, f"{text} of r/min (unit krpm), or turns a second (unit Hz)?"))
    return found
