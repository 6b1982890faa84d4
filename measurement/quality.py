"""What looks wrong with a run's data, said beside its summary so that no figure is read blindly.

Only what needs no model: channels that stand still, sit at the end of their range, or are missing.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from measurement.resampling import GAP_INTERVALS
from measurement.runs import FloatArray, Run
from measurement.units import UNITS, split_column

FROZEN_S = 900.0
"""A displacement that is exactly constant for longer is looked at [s]. Thermal drift that goes on
leaves a sensor's resolution step within a quarter of an hour; slower drift is told apart by what
the other channels do."""

MOVING_K = 2.0
"""A temperature that changes by this much in the meantime says that the machine is not at rest [K].
In a good record with steps of 0.25 um the growth stood still for up to 107 min while temperatures
moved by at most 0.9 K; while known frozen channels stood still they moved by 3 K and more."""

MOVING_UM = 5.0
"""So does another displacement that changes by this much [um]: beyond any resolution step."""

FROZEN_SAMPLES = 5
"""Fewer equal samples in a row say nothing, however far apart they are."""

ISOLATED_SHARE = 0.5
"""An extreme value that lies further from all others than this share of their range was jumped to:
the end of the sensor's range, not the end of a drift."""

MISSING_SHARE = 0.01
"""A channel with a larger share of missing samples is named: below, averaging hides it well."""

JUMP_K = 2.0
"""Half of all temperatures moving by more than this from one sample to the next is no heat flow
[K]: two recordings were joined, or the logger restarted. The largest step of the middle sensor is
0.1 K in 30 good records, and 4.3 K in one that shows such a seam."""

_NOT_READINGS = ("offset_", "error_")  # computed by a plant: an offset may rightly stand still


@dataclass(frozen=True)
class Finding:
    """Something that looks wrong.

    Attributes
    ----------
    kind : str
        ``frozen``, ``saturated``, ``missing``, ``pause`` or ``jump``.
    column : str
        The channel; ``time_s`` for what befell the whole record.
    start_s, end_s : float
        When [s].
    text : str
        One line that a person can read.
    """

    kind: str
    column: str
    start_s: float
    end_s: float
    text: str

    def to_dict(self) -> dict[str, Any]:
        """Return the finding as a plain dict."""
        return asdict(self)


def look_over(run: Run) -> list[Finding]:
    """Return what looks wrong with a run: pauses, missing shares, channels that stand still."""
    findings = [*_pauses(run), *_jumps(run)]
    for name in map(str, run.frame.columns[1:]):
        findings += _missing(run, name)
    for name in run.displacements:
        if not name.startswith(_NOT_READINGS):
            findings += _standstills(run, name)
    return findings


def _pauses(run: Run) -> Iterator[Finding]:
    steps = np.diff(run.time_s)
    if steps.size < FROZEN_SAMPLES:
        return
    usual = float(np.median(steps))
    long = np.flatnonzero(steps > GAP_INTERVALS * usual)
    if long.size:
        at = long[np.argmax(steps[long])]
        start, end = float(run.time_s[at]), float(run.time_s[at + 1])
        text = (
            f"{long.size} {'pause' if long.size == 1 else 'pauses'} of more than "
            f"{GAP_INTERVALS:g} usual intervals ({usual:g} s) in the record, the longest of "
            f"{(end - start) / 60:.1f} min from {start / 60:.0f} min on"
        )
        yield Finding("pause", "time_s", start, end, text)


def _jumps(run: Run) -> Iterator[Finding]:
    if len(run.temperatures) < 2 or len(run.frame) < 2:
        return
    steps = np.abs(np.diff(run.frame[run.temperatures].to_numpy(), axis=0))
    # A missing neighbour is not a jump, and over a pause heat has time to flow.
    jumped = (np.nan_to_num(steps) > JUMP_K).sum(axis=1) >= len(run.temperatures) / 2
    time_steps = np.diff(run.time_s)
    jumped &= time_steps <= GAP_INTERVALS * np.median(time_steps)
    for at in np.flatnonzero(jumped).tolist():
        start, end = float(run.time_s[at]), float(run.time_s[at + 1])
        text = (
            f"half of the temperatures or more jump by over {JUMP_K:g} K between two samples "
            f"at {start / 60:.0f} min: joined recordings, or the logger restarted"
        )
        yield Finding("jump", "time_s", start, end, text)


def _missing(run: Run, name: str) -> Iterator[Finding]:
    missing = np.isnan(run.frame[name].to_numpy())
    share = float(missing.mean())
    if share > MISSING_SHARE:
        where = run.time_s[missing]
        text = f"{share:.1%} of the samples are missing"
        yield Finding("missing", name, float(where[0]), float(where[-1]), text)


def _standstills(run: Run, name: str) -> Iterator[Finding]:
    values = run.frame[name].to_numpy()
    valid = np.flatnonzero(~np.isnan(values))
    for first, last in _constant_stretches(run.time_s[valid], values[valid]):
        start, end = valid[first], valid[last]
        moved = _what_moved(run, name, int(start), int(end))
        if moved is None:
            continue
        value = float(values[start])
        minutes = (run.time_s[end] - run.time_s[start]) / 60
        saturated = _at_end_of_range(run, values, int(start), int(end))
        kind = "saturated" if saturated else "frozen"
        unit = UNITS[split_column(name)[1]].suffix
        text = (
            f"exactly {value:g} {unit} for {minutes:.0f} min from "
            f"{run.time_s[start] / 60:.0f} min on while {moved}"
        )
        if saturated:
            text += "; it is the channel's own extreme: the end of the sensor's range"
        yield Finding(kind, name, float(run.time_s[start]), float(run.time_s[end]), text)


def _constant_stretches(time: FloatArray, values: FloatArray) -> Iterator[tuple[int, int]]:
    if not values.size:
        return
    cuts = np.flatnonzero(np.diff(values) != 0.0) + 1
    firsts, lasts = np.r_[0, cuts], np.r_[cuts, values.size] - 1
    long = (time[lasts] - time[firsts] > FROZEN_S) & (lasts - firsts + 1 >= FROZEN_SAMPLES)
    yield from zip(firsts[long].tolist(), lasts[long].tolist(), strict=True)


def _what_moved(run: Run, name: str, start: int, end: int) -> str | None:
    """Return in words what moved most between two samples, or None if all stood still."""
    part = run.frame.iloc[start : end + 1]
    for others, enough, unit in (
        (run.temperatures, MOVING_K, "K"),
        ([other for other in run.displacements if other != name], MOVING_UM, "um"),
    ):
        moved = {other: _spread(part[other].to_numpy()) for other in others}
        most = max(moved, key=moved.__getitem__, default=None)
        if most is not None and moved[most] >= enough:
            return f"{split_column(most)[0]} moved by {moved[most]:.1f} {unit}"
    return None


def _spread(values: FloatArray) -> float:
    """Return the range without the outermost twentieths, so that one bad sample does not count."""
    values = values[~np.isnan(values)]
    return float(np.subtract(*np.percentile(values, [95, 5]))) if values.size else 0.0


def _at_end_of_range(run: Run, values: FloatArray, start: int, end: int) -> bool:
    """Return whether the standstill is at the end of the sensor's range.

    It is at the channel's own extreme, and either far from all other values or reached while the
    spindle was turning (a channel that a stop freezes is at its extreme by chance).
    """
    value = values[start]
    others = values[~np.isnan(values) & (values != value)]
    if not others.size or others.min() < value < others.max():
        return False
    distance = float(np.abs(others - value).min())
    if distance > ISOLATED_SHARE * float(np.ptp(others)) > 0.0:
        return True
    speeds = run.of_unit("rpm")
    if not speeds:
        return True
    turning = run.frame[speeds[0]].ffill().to_numpy()[start : end + 1] != 0.0
    return bool(turning.mean() > 0.5)
