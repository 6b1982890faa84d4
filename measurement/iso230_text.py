"""Formats an ISO 230-3 style summary as lines of text."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import TYPE_CHECKING

from measurement.errors import MOST_LISTED
from measurement.faults import faults_text
from measurement.units import split_column

if TYPE_CHECKING:
    from measurement.iso230 import Ranges, Summary


def summary_text(summary: Summary) -> str:
    """Return the summary as text, at most 100 characters wide except for the findings."""
    parts = [
        _head(summary),
        _spectrum(summary),
        _movements(summary),
        _temperatures(summary),
        _findings(summary),
    ]
    return "\n\n".join("\n".join(lines) for lines in map(list, parts) if lines)


def _head(summary: Summary) -> Iterator[str]:
    yield f"Run {summary.name}"
    yield f"  test (ISO 230-3 style)   {summary.test}"
    yield (
        f"  record                   {_minutes(summary.duration_s)} min, "
        f"{summary.samples} samples, every {summary.interval_s:.4g} s "
        f"(longest {summary.longest_interval_s:.4g} s)"
    )
    if summary.running_period_s is not None:
        first, last = summary.running_period_s
        yield (
            f"  running / stopped        {_minutes(summary.running_s)} min / "
            f"{_minutes(summary.stopped_s)} min; running period {_minutes(first)} to "
            f"{_minutes(last)} min"
        )
        full = "yes" if summary.is_standard_spindle_test else "no"
        yield f"  4 h on, then 1 h off     {full}"
    if summary.ambient is not None:
        air = summary.ambient
        yield (
            f"  ambient                  {air.start:.1f} degC at the start, "
            f"{air.lowest:.1f} to {air.highest:.1f} degC, drift {air.drift:+.1f} K "
            f"({air.column})"
        )
    else:
        yield "  ambient                  not known: --ambient names its column"


def _spectrum(summary: Summary) -> Iterator[str]:
    if all(segment.state == "unknown" for segment in summary.segments):
        return
    yield "Speed spectrum      from min    for min     r/min"
    for segment in summary.segments[:MOST_LISTED]:
        speed = "unknown" if math.isnan(segment.speed_rpm) else f"{segment.speed_rpm:.0f}"
        start, length = _minutes(segment.start_s), _minutes(segment.duration_s)
        yield f"{start:>28}{length:>11}{speed:>10}"
    if len(summary.segments) > MOST_LISTED:
        yield f"{'':>20}and {len(summary.segments) - MOST_LISTED} more"


def _movements(summary: Summary) -> Iterator[str]:
    if not summary.displacements:
        return
    head = ("first 60 min", "running", "whole", "change")
    yield f"{'Range of':<28}" + "".join(f"{word:>14}" for word in head)
    for name, ranges in summary.displacements.items():
        place = summary.places.get(name)
        signal, unit = split_column(name)
        label = f"{signal} ({place})" if place else signal
        yield _movement(label, unit, ranges)
    for name, ranges in summary.pose.items():
        yield _movement(*split_column(name), ranges)
    if summary.spacing_mm is not None:
        yield f"  Tilt over a sensor spacing of {summary.spacing_mm:g} mm; 1 urad is 1 um/m."


def _movement(label: str, unit: str, ranges: Ranges) -> str:
    numbers = (ranges.first_60_min, ranges.running, ranges.whole)
    cells = "".join(f"{_number(number):>14}" for number in numbers)
    return f"  {label:<20}{unit:<6}{cells}{_number(ranges.change, '+'):>14}"


def _temperatures(summary: Summary) -> Iterator[str]:
    if not summary.temperatures:
        return
    head = ("start", "highest", "rise K", "last")
    yield f"{'Temperature':<28}" + "".join(f"{word:>14}" for word in head)
    for name, warming in summary.temperatures.items():
        signal, unit = split_column(name)
        numbers = (warming.start, warming.highest, warming.rise, warming.last)
        yield f"  {signal:<20}{unit:<6}" + "".join(f"{_number(n):>14}" for n in numbers)


def _findings(summary: Summary) -> Iterator[str]:
    if not summary.findings:
        return
    yield "What is wrong with the data"
    yield faults_text(summary.findings)


def _minutes(seconds: float) -> str:
    return f"{seconds / 60:.1f}"


def _number(value: float, sign: str = "") -> str:
    return "-" if math.isnan(value) else f"{value:{sign}.1f}"
