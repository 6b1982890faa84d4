"""What is wrong with a set of runs: the checks of one run, and those that need several.

`measurement.quality` looks at a run alone. Here its findings come together with what shows only
against other runs or other sensors: a sensor whose level jumps between runs, one that leaves all
others within a run, displacement that froze and jumps when it comes back, and readings on a coarse
staircase.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from measurement.quality import Finding, look_over
from measurement.runs import FloatArray, Run
from measurement.units import split_column

LEVEL_JUMP_K = 10.0
"""A sensor whose level, against the middle of all others, moves by this much from one run to the
next has jumped [K]. Different work warms sensors differently, but by less than this."""
STRAY_K = 10.0
"""A sensor leaves the others within a run if it goes this far from their middle [K], and ..."""
STRAY_FACTOR = 3.0
"""... this many times further than in its other runs [1]."""
RESTART_UM = 3.0
"""A displacement that comes back from a standstill this far away has moved unseen [um]."""
COARSE_SHARE = 1 / 200
"""Readings whose smallest step is more than this share of their range are on a staircase [1]."""
STANDING_SHARE = 0.5
"""So are those that repeat the reading before in more than this share of samples [1]."""


@dataclass(frozen=True)
class Fault:
    """Something wrong with the data.

    Attributes
    ----------
    kind : str
        ``level_jump``, ``stray``, ``frozen``, ``saturated``, ``restart``, ``staircase``,
        ``missing``, ``pause`` or ``jump``.
    column : str
        The channel; ``time_s`` for what befell the whole record.
    runs : tuple of str
        Where it was seen.
    text : str
        One line that a person can read.
    handling : str
        What becomes of it before a model is fitted.
    """

    kind: str
    column: str
    runs: tuple[str, ...]
    text: str
    handling: str

    def to_dict(self) -> dict[str, Any]:
        """Return the fault as a plain dict."""
        return asdict(self) | {"runs": list(self.runs)}


HANDLING = {
    "level_jump": "not used where levels count; rises do not feel it",
    "stray": "the sensor is not used",
    "frozen": "these rows are left out of fitting and judging",
    "saturated": "these rows are left out of fitting and judging",
    "restart": "kept: the reading is right again after it",
    "staircase": "kept: no error below the step can be told",
    "missing": "rows without a value are left out",
    "pause": "kept: models go by time, not by rows",
    "jump": "kept, unless displacement froze there",
}


def find_faults(runs: Sequence[Run]) -> list[Fault]:
    """Return what is wrong with runs, the gravest kinds first.

    Parameters
    ----------
    runs : sequence of Run
        In the order in which they were recorded, so that a change from one to the next shows.
    """
    faults = [*_level_jumps(runs), *_strays(runs)]
    found = [(run, finding) for run in runs for finding in look_over(run)]
    faults += _gathered([(run, one) for run, one in found if one.kind == "saturated"])
    faults += _gathered([(run, one) for run, one in found if one.kind == "frozen"])
    faults += _restarts([(run, one) for run, one in found if one.kind == "frozen"])
    faults += _staircases(runs)
    rest = ("missing", "pause", "jump")
    return faults + _gathered([(run, one) for run, one in found if one.kind in rest])


def faults_text(faults: Sequence[Fault]) -> str:
    """Return faults as lines, each with what becomes of it."""
    if not faults:
        return "  nothing that these checks see"
    return "\n".join(f"  {fault.text}\n    -> {fault.handling}" for fault in faults)


def _fault(kind: str, column: str, runs: Sequence[str], text: str) -> Fault:
    return Fault(kind, column, tuple(dict.fromkeys(runs)), text, HANDLING[kind])


def _gathered(found: Sequence[tuple[Run, Finding]]) -> list[Fault]:
    """Return one fault for all findings of a kind on a column."""
    groups: dict[tuple[str, str], list[tuple[Run, Finding]]] = {}
    for run, finding in found:
        groups.setdefault((finding.kind, finding.column), []).append((run, finding))
    faults = []
    for (kind, column), members in groups.items():
        names = [run.name for run, _ in members]
        if len(members) == 1:
            text = f"{column} in {names[0]}: {members[0][1].text}"
        else:
            minutes = sum(one.end_s - one.start_s for _, one in members) / 60.0
            word = {"frozen": "frozen", "saturated": "at the end of its range"}.get(kind, kind)
            text = f"{column}: {word} {len(members)} times, {minutes:.0f} min, in {_listed(names)}"
        faults.append(_fault(kind, column, names, text))
    return faults


def _against_others(runs: Sequence[Run], columns: Sequence[str]) -> FloatArray:
    """Return each sensor's median reading less the middle of the others', (runs, columns) [K]."""
    level = np.array([[_median(run.frame[name].to_numpy()) for name in columns] for run in runs])
    others = [_middle(np.delete(level, place, axis=1)) for place in range(len(columns))]
    return np.asarray(level - np.column_stack(others))


def _middle(levels: FloatArray) -> FloatArray:
    """Return the median of each row; NaN where a row has no value."""
    return np.array([_median(row) for row in levels])


def _median(values: FloatArray) -> float:
    values = values[np.isfinite(values)]
    return float(np.median(values)) if values.size else float("nan")


def _shared(runs: Sequence[Run]) -> list[str]:
    return [name for name in runs[0].temperatures if all(name in run.frame for run in runs)]


def _level_jumps(runs: Sequence[Run]) -> list[Fault]:
    """Return sensors whose level changes for good, or for some runs, as no other's does."""
    columns = _shared(runs)
    if len(runs) < 3 or len(columns) < 3:
        return []
    away = _against_others(runs, columns)
    faults = []
    for place, name in enumerate(columns):
        series = away[:, place]
        if not np.isfinite(series).all():
            continue
        # The split of the runs, in their order, that explains most of the differences.
        sizes = np.arange(1, len(series))
        steps = np.array([np.median(series[k:]) - np.median(series[:k]) for k in sizes])
        spread = [_spread_about(series, int(k)) for k in sizes]
        at = int(np.argmin(spread))
        step = float(steps[at])
        if abs(step) >= LEVEL_JUMP_K and abs(step) > 3.0 * spread[at]:
            high = "high" if step > 0 else "low"
            after = [run.name for run in runs[at + 1 :]]
            signal = split_column(name)[0]
            text = f"{name}: {signal} reads {abs(step):.0f} K {high} from {after[0]} on"
            faults.append(_fault("level_jump", name, after, text))
            continue
        usual = float(np.median(series))
        odd = np.flatnonzero(np.abs(series - usual) >= LEVEL_JUMP_K)
        if odd.size:
            names = [runs[int(k)].name for k in odd]
            off = float(series[odd[np.argmax(np.abs(series[odd] - usual))]] - usual)
            text = f"{name}: {off:+.0f} K from its usual level in {_listed(names)}"
            faults.append(_fault("level_jump", name, names, text))
    return faults


def _spread_about(series: FloatArray, cut: int) -> float:
    parts = (series[:cut], series[cut:])
    return float(np.mean(np.concatenate([np.abs(part - np.median(part)) for part in parts])))


def _strays(runs: Sequence[Run]) -> list[Fault]:
    """Return sensors that leave all others within one run."""
    columns = _shared(runs)
    if len(runs) < 2 or len(columns) < 3:
        return []
    furthest = np.zeros((len(runs), len(columns)))
    for row, run in enumerate(runs):
        rises = run.frame[columns].bfill().to_numpy()
        rises = rises - rises[0]
        away = rises - np.nanmedian(rises, axis=1, keepdims=True)
        place = np.nanargmax(np.abs(np.nan_to_num(away)), axis=0)
        furthest[row] = away[place, np.arange(len(columns))]
    faults = []
    size = np.abs(furthest)
    for place, name in enumerate(columns):
        worst = int(np.argmax(size[:, place]))
        run = runs[worst]
        others = np.delete(size[:, place], worst).max()
        if size[worst, place] >= max(STRAY_K, STRAY_FACTOR * others):
            off = furthest[worst, place]
            text = f"{name}: within {run.name} it leaves all others by {off:+.0f} K"
            faults.append(_fault("stray", name, [run.name], text))
    return faults


def _restarts(frozen: Sequence[tuple[Run, Finding]]) -> list[Fault]:
    """Return displacements that come back far from where they froze."""
    jumps: dict[str, list[tuple[str, float]]] = {}
    for run, finding in frozen:
        values = run.frame[finding.column].to_numpy()
        after = np.flatnonzero((run.time_s > finding.end_s) & np.isfinite(values))
        at = values[np.searchsorted(run.time_s, finding.start_s)]
        # A few samples on: the reading may take one or two to come back.
        if after.size >= 3 and abs(step := float(np.median(values[after[:5]]) - at)) > RESTART_UM:
            jumps.setdefault(finding.column, []).append((run.name, step))
    faults = []
    for column, found in jumps.items():
        largest = max((step for _, step in found), key=abs)
        names = [name for name, _ in found]
        text = f"{column}: jumps by up to {largest:+.0f} um on coming back, in {_listed(names)}"
        faults.append(_fault("restart", column, names, text))
    return faults


def _staircases(runs: Sequence[Run]) -> list[Fault]:
    """Return displacements that are read in coarse steps, or stand still between them."""
    steps: dict[str, list[tuple[str, float, float]]] = {}
    for run in runs:
        for name in run.displacements:
            values = run.frame[name].dropna().to_numpy()
            moves = np.abs(np.diff(values))
            if not (moves > 0).any():
                continue
            still = float((moves == 0).mean())
            usual = float(np.median(moves[moves > 0]))
            if usual > COARSE_SHARE * float(np.ptp(values)) and still > STANDING_SHARE:
                steps.setdefault(name, []).append((run.name, usual, still))
    faults = []
    for name, found in steps.items():
        usual = float(np.median([step for _, step, _ in found]))
        still = float(np.median([share for _, _, share in found]))
        names = [run for run, _, _ in found]
        text = (
            f"{name}: a staircase with steps of {usual:.2g} um, unchanged in {still:.0%} of "
            f"samples, in {_listed(names)}"
        )
        faults.append(_fault("staircase", name, names, text))
    return faults


def _listed(names: Sequence[str]) -> str:
    names = list(dict.fromkeys(names))
    return (
        ", ".join(names) if len(names) <= 3 else f"{len(names)} runs ({names[0]} ... {names[-1]})"
    )
