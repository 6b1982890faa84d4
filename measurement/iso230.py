"""Summarises a run in the terms of ISO 230-3 (2007 and 2020), like a report of thermal tests.

The standard's tests: the *environmental temperature variation error* (the spindle stands, the hall
changes), the *thermal distortion caused by rotating spindle* (4 h running, then 1 h stopped), and
the one *caused by moving linear axes*. A report states the range of each sensor's reading in the
first 60 min and over the running period, the tilts, the sensors' distance, the speed spectrum, and
the temperatures. This is a summary of any run in that style, not a certificate.
"""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from measurement.errors import BadInput
from measurement.faults import Fault, cleaned, find_faults
from measurement.files import json_ready
from measurement.iso230_text import summary_text
from measurement.rig import POSE, FivePointRig, Rig
from measurement.runs import FloatArray, Run
from measurement.spectrum import Segment, speed_spectrum
from measurement.units import split_column

FIRST_S, RUNNING_S, STOPPED_S = 3600.0, 4 * 3600.0, 3600.0
"""Length of the first period, and least running time and standstill after it, given by ISO 230-3
[s]."""


@dataclass(frozen=True)
class Ranges:
    """Range of one quantity: largest minus smallest value [um, or urad for a tilt].

    Attributes
    ----------
    first_60_min : float
        In the first 60 min of the running period, or of the record if the spindle never ran.
    running : float
        From the first start to the last stop; NaN if the spindle never ran.
    whole : float
        Over the whole record.
    change : float
        Last minus first value, over the running period or else the record.
    """

    first_60_min: float
    running: float
    whole: float
    change: float


@dataclass(frozen=True)
class Warming:
    """Change of one temperature [degC; rise in K]."""

    start: float
    highest: float
    rise: float
    last: float


@dataclass(frozen=True)
class Ambient:
    """Change of the ambient temperature [degC; drift and range in K].

    ``drift`` is the last value minus the first.
    """

    column: str
    start: float
    lowest: float
    highest: float
    range: float
    drift: float


@dataclass(frozen=True)
class Summary:
    """The result of :func:`summarise`; times in s, other units as in the columns' names."""

    name: str
    test: str
    samples: int
    duration_s: float
    interval_s: float
    longest_interval_s: float
    running_s: float
    stopped_s: float
    unknown_s: float
    running_period_s: tuple[float, float] | None
    is_standard_spindle_test: bool
    segments: list[Segment]
    displacements: dict[str, Ranges]
    places: dict[str, str]
    pose: dict[str, Ranges]
    spacing_mm: float | None
    temperatures: dict[str, Warming]
    ambient: Ambient | None
    findings: list[Fault]

    def text(self) -> str:
        """Return the summary as lines of text for a terminal."""
        return summary_text(self)

    def to_dict(self) -> dict[str, Any]:
        """Return everything as plain dicts and lists for JSON; None if unknown."""
        table = asdict(self)
        table["segments"] = [segment.to_dict() for segment in self.segments]
        table["findings"] = [fault.to_dict() for fault in self.findings]
        return dict(json_ready(table))


def summarise(run: Run, rig: Rig | None = None, ambient: str | None = None) -> Summary:
    """Return the ISO 230-3 style summary of a run.

    Parameters
    ----------
    run : Run
        Any run; quantities without a column are left out.
    rig : FivePointRig or DirectRig, optional
        Defines the columns; with a five-point rig that fits the run, the summary includes
        elongation and tilts.
    ambient : str, optional
        Column of the ambient temperature.

    Raises
    ------
    BadInput
        If the run lacks the ambient column, or it is not a temperature.
    """
    faults = find_faults([run])
    # A spike must not count as range, nor a slipped probe as drift.
    run = cleaned([run], faults)[0]
    segments = speed_spectrum(run)
    total = {
        state: math.fsum(part.duration_s for part in segments if part.state == state)
        for state in ("running", "stopped", "unknown")
    }
    period = _running_period(segments)
    five_point = rig if isinstance(rig, FivePointRig) and rig.fits(run) else None
    pose = five_point.pose(run.frame) if five_point else None
    steps = np.diff(run.time_s)
    return Summary(
        name=run.name,
        test=_test(run, segments),
        samples=len(run.frame),
        duration_s=float(run.time_s[-1] - run.time_s[0]),
        interval_s=float(np.median(steps)) if steps.size else math.nan,
        longest_interval_s=float(steps.max()) if steps.size else math.nan,
        running_s=total["running"],
        stopped_s=total["stopped"],
        unknown_s=total["unknown"],
        running_period_s=period,
        is_standard_spindle_test=_is_standard_test(segments, run.time_s),
        segments=segments,
        displacements={
            name: _ranges(run.time_s, run.frame[name].to_numpy(), period)
            for name in run.displacements
        },
        places=_places(rig, run),
        pose={}
        if pose is None
        else {name: _ranges(run.time_s, pose[name].to_numpy(), period) for name in POSE[:3]},
        spacing_mm=five_point.spacing_mm if five_point else None,
        temperatures={name: _warming(run.frame[name].to_numpy()) for name in run.temperatures},
        ambient=None if ambient is None else _ambient(run, ambient),
        findings=[*_not_there(rig, run), *faults],
    )


def _test(run: Run, segments: list[Segment]) -> str:
    feeds = any(bool((run.frame[name].fillna(0.0) != 0.0).any()) for name in run.of_unit("mm_min"))
    states = {segment.state for segment in segments}
    if "running" in states:
        also = ", with linear axes moving" if feeds else ""
        return "thermal distortion caused by rotating spindle" + also
    if feeds:
        return "thermal distortion caused by moving linear axes"
    if "stopped" in states:
        return "environmental temperature variation error (ETVE)"
    return "not known: no spindle speed was recorded"


def _running_period(segments: list[Segment]) -> tuple[float, float] | None:
    running = [segment for segment in segments if segment.state == "running"]
    return (running[0].start_s, running[-1].end_s) if running else None


def _is_standard_test(segments: list[Segment], time: FloatArray) -> bool:
    """Return whether at least 4 h of running are followed by at least 1 h of standstill.

    A shorter standstill is part of the running. A log may start one sample late and end one early.
    """
    late, start = 2.0 * float(np.median(np.diff(time))) if time.size > 1 else 0.0, None
    for segment in segments:
        if segment.state == "running":
            start, end = segment.start_s if start is None else start, segment.end_s
        elif start is not None and segment.duration_s + late >= STOPPED_S:
            if end - start + late >= RUNNING_S:
                return True
            start = None
    return False


def _ranges(time: FloatArray, values: FloatArray, period: tuple[float, float] | None) -> Ranges:
    start, end = period or (float(time[0]), float(time[-1]))
    inside = (time >= start) & (time <= end)
    part = values[inside]
    part = part[~np.isnan(part)]
    return Ranges(
        first_60_min=_range(values[inside & (time <= start + FIRST_S)]),
        running=_range(part) if period else math.nan,
        whole=_range(values),
        change=float(part[-1] - part[0]) if part.size else math.nan,
    )


def _range(values: FloatArray) -> float:
    values = values[~np.isnan(values)]
    return float(np.ptp(values)) if values.size else math.nan


def _warming(values: FloatArray) -> Warming:
    values = values[~np.isnan(values)]
    if not values.size:
        return Warming(math.nan, math.nan, math.nan, math.nan)
    start, highest = float(values[0]), float(values.max())
    return Warming(start, highest, highest - start, float(values[-1]))


def _ambient(run: Run, column: str) -> Ambient:
    source = run.path or run.name
    if column not in run.frame.columns:
        listed = ", ".join(run.temperatures) or "none"
        raise BadInput(source, "ambient", f"no column {column!r}; its temperatures: {listed}")
    if split_column(column)[1] != "degC":
        raise BadInput(source, "ambient", f"column {column!r} is not a temperature in degC")
    values = run.frame[column].dropna().to_numpy()
    if not values.size:
        raise BadInput(source, "ambient", f"column {column!r} holds no value")
    low, high = float(values.min()), float(values.max())
    start, last = float(values[0]), float(values[-1])
    return Ambient(column, start, low, high, high - low, last - start)


def _not_there(rig: Rig | None, run: Run) -> list[Fault]:
    """Return a fault for each column of the rig that the run lacks."""
    text = "the rig has this column but the run does not"
    return [
        Fault.between(run, name, "absent", 0, -1, text)
        for name in (rig.columns if rig is not None else [])
        if name not in run.frame.columns
    ]


def _places(rig: Rig | None, run: Run) -> dict[str, str]:
    """Return what each displacement column measures, in words."""
    if rig is None:
        return {}
    if isinstance(rig, FivePointRig):
        places = ["near, X", "near, Y", "distal, X", "distal, Y", "axial"]
    else:
        places = [f"{'+' if entry.sign > 0 else '-'}{entry.axis}" for entry in rig.axes.values()]
    named = zip(rig.columns, places, strict=True)
    return {name: place for name, place in named if name in run.frame.columns}
