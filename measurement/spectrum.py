"""The speed spectrum: when the spindle turned, and how fast."""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from measurement.runs import Run

STILL_RPM = 1.0
"""Below this speed the spindle is at a standstill [r/min]: set on no data."""

SAME_SPEED_SHARE = 0.01
"""Speeds that differ by less than this share of the largest belong to one step of the spectrum
(likewise other signals that switch): a measured speed fluctuates, and the steps of test spectra are
much larger. Set on no data: 0.02 finds the same steps in all measured runs."""


@dataclass(frozen=True)
class Segment:
    """A period of constant speed.

    Attributes
    ----------
    speed_rpm : float
        The speed; NaN if none was recorded [r/min].
    start_s, end_s : float
        From its first sample to the first sample of the next one [s].
    """

    speed_rpm: float
    start_s: float
    end_s: float

    @property
    def duration_s(self) -> float:
        """Duration [s]."""
        return self.end_s - self.start_s

    @property
    def state(self) -> str:
        """``running``, ``stopped`` or ``unknown``."""
        if math.isnan(self.speed_rpm):
            return "unknown"
        return "running" if abs(self.speed_rpm) >= STILL_RPM else "stopped"

    def to_dict(self) -> dict[str, Any]:
        """Return the segment as a plain dict."""
        return asdict(self) | {"duration_s": self.duration_s, "state": self.state}


def speed_column(run: Run) -> str | None:
    """Return the column of the spindle speed: ``speed_rpm``, or the only one in r/min."""
    columns = run.of_unit("rpm")
    if "speed_rpm" in columns:
        return "speed_rpm"
    return columns[0] if len(columns) == 1 else None


def speed_spectrum(run: Run) -> list[Segment]:
    """Return the steps of the spindle speed in order; one unknown step if none was recorded.

    A sample's speed holds until the next sample, and over samples without a speed.

    Parameters
    ----------
    run : Run
    """
    time = run.time_s
    name = speed_column(run)
    if name is None:
        return [Segment(math.nan, float(time[0]), float(time[-1]))]
    speed = run.frame[name].ffill().to_numpy()
    known = speed[~np.isnan(speed)]
    largest = float(np.abs(known).max()) if known.size else 0.0
    same = max(STILL_RPM, SAME_SPEED_SHARE * largest)
    starts = [0]
    for i in range(1, speed.size):
        if _differs(speed[starts[-1]], speed[i], same):
            starts.append(i)
    segments = []
    for first, after in zip(starts, [*starts[1:], speed.size], strict=True):
        end = time[min(after, speed.size - 1)]
        middle = float(np.median(speed[first:after]))
        segments.append(Segment(middle, float(time[first]), float(end)))
    # A step that begins with the last sample has no duration.
    return [step for step in segments if step.duration_s > 0.0] or segments[:1]


def _differs(reference: float, speed: float, same: float) -> bool:
    if math.isnan(reference) or math.isnan(speed):
        return math.isnan(reference) != math.isnan(speed)
    stopped = (abs(reference) < STILL_RPM, abs(speed) < STILL_RPM)
    return stopped[0] != stopped[1] or abs(speed - reference) > same
