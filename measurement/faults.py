"""What is wrong with a set of runs: the checks of one run, and those that need several.

`measurement.quality` looks at a run alone. Here its findings come together with what shows only
against other runs or other sensors: a sensor whose level jumps between runs, one that leaves all
others within a run, displacement that froze and jumps when it comes back, and readings on a coarse
staircase. `measurement.channels` adds single channels that are broken for a while.

A fault with spans is gross: what was read then is not what the machine did, and a model is neither
fitted to it nor judged by it. `unusable` gathers these spans.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from typing import Any

import numpy as np

from measurement.channels import broken_readings, near_switch
from measurement.levels import listed, strays, wrong_levels
from measurement.quality import Finding, look_over
from measurement.runs import Run
from measurement.units import split_column

RESTART_UM = 3.0
"""A displacement that comes back from a standstill this far away has moved unseen [um]."""
COARSE_SHARE = 1 / 200
"""Readings whose smallest step is more than this share of their range are on a staircase [1]."""
STANDING_SHARE = 0.5
"""So are those that repeat the reading before in more than this share of samples [1]."""


@dataclass(frozen=True)
class Span:
    """Where a channel is not to be used: the run, from when to when [s], and why in one line."""

    run: str
    start_s: float
    end_s: float
    text: str


@dataclass(frozen=True)
class Fault:
    """Something wrong with the data.

    Attributes
    ----------
    kind : str
        ``level_jump``, ``never_right``, ``stray``, ``runaway``, ``dead``, ``frozen``,
        ``saturated``, ``step``, ``spikes``, ``restart``, ``staircase``, ``missing``, ``pause`` or
        ``jump``.
    column : str
        The channel; ``time_s`` for what befell the whole record.
    runs : tuple of str
        Where it was seen.
    text : str
        One line that a person can read.
    handling : str
        What becomes of it before an error model is fitted.
    spans : tuple of Span
        What is not to be used, where the fault is gross.
    """

    kind: str
    column: str
    runs: tuple[str, ...]
    text: str
    handling: str
    spans: tuple[Span, ...] = ()

    def to_dict(self) -> dict[str, Any]:
        """Return the fault as a plain dict."""
        return asdict(self) | {"runs": list(self.runs), "spans": [asdict(s) for s in self.spans]}


HANDLING = {
    "level_jump": "not used where levels count; rises do not feel it",
    "never_right": "not used where levels count; rises do not feel it",
    "stray": "the sensor is not used",
    "runaway": "the sensor is not used",
    "dead": "the sensor is not used",
    "step": "kept: an error model that follows it would be worse, and says so on unseen runs",
    "spikes": "kept: single rows hardly move a fit",
    "frozen": "these rows are left out of fitting and judging",
    "saturated": "these rows are left out of fitting and judging",
    "restart": "kept: the reading is right again after it",
    "staircase": "kept: no error below the step can be told",
    "missing": "rows without a value are left out",
    "pause": "kept: models go by time, not by rows",
    "jump": "kept, unless displacement froze there",
}


GROSS = ("saturated", "frozen", "dead", "runaway", "step", "spikes")
"""Kinds of findings whose time is not to be used."""


def find_faults(runs: Sequence[Run]) -> list[Fault]:
    """Return what is wrong with runs, the gravest kinds first.

    Parameters
    ----------
    runs : sequence of Run
        In the order in which they were recorded, so that a change from one to the next shows.
    """
    found = [(run, finding) for run in runs for finding in look_over(run)]
    frozen = [(run, one) for run, one in found if one.kind == "frozen"]
    found = _outside_seams([*found, *broken_readings(runs)])
    begun = {
        (run.name, one.column): one.start_s for run, one in found if one.kind in ("runaway", "step")
    }
    faults = [
        _in_whole_runs(_fault(kind, column, names, text), runs, begun)
        for kind, column, names, text in wrong_levels(runs)
        # A level that is off only where the sensor broke is no second fault.
        if not all((name, column) in begun for name in names)
    ]
    faults += [_fault("stray", column, names, text) for column, names, text in strays(runs)]
    for kind in GROSS:
        faults += _gathered([(run, one) for run, one in found if one.kind == kind])
    faults += _restarts(frozen)
    faults += _staircases(runs)
    rest = ("missing", "pause", "jump")
    return faults + _gathered([(run, one) for run, one in found if one.kind in rest])


def unusable(faults: Sequence[Fault]) -> list[tuple[Fault, Span]]:
    """Return what is not to be used, each fault with one of its spans, by run and time.

    A span inside another one of the same column is not repeated. A fault of ``time_s`` is one of
    every column.
    """
    every = [(fault, span) for fault in faults for span in fault.spans]
    widest = sorted(every, key=lambda pair: pair[1].start_s - pair[1].end_s)
    kept: list[tuple[Fault, Span]] = []
    for fault, span in widest:
        inside = (
            one
            for one in kept
            if one[0].column == fault.column
            and one[1].run == span.run
            and one[1].start_s <= span.start_s
            and span.end_s <= one[1].end_s
        )
        if next(inside, None) is None:
            kept.append((fault, span))
    return sorted(kept, key=lambda pair: (pair[1].run, pair[0].column, pair[1].start_s))


def faults_text(faults: Sequence[Fault]) -> str:
    """Return faults as lines, each with what becomes of it."""
    if not faults:
        return "  nothing that these checks see"
    return "\n".join(f"  {fault.text}\n    -> {fault.handling}" for fault in faults)


def _fault(kind: str, column: str, runs: Sequence[str], text: str) -> Fault:
    return Fault(kind, column, tuple(dict.fromkeys(runs)), text, HANDLING[kind])


def _in_whole_runs(
    fault: Fault, runs: Sequence[Run], begun: Mapping[tuple[str, str], float]
) -> Fault:
    """Return a fault whose column is not to be used in its runs, or from where it broke."""
    spans = [
        Span(
            run.name,
            begun.get((run.name, fault.column), float(run.time_s[0])),
            float(run.time_s[-1]),
            fault.text,
        )
        for run in runs
        if run.name in fault.runs
    ]
    return replace(fault, spans=tuple(spans))


def _outside_seams(found: Sequence[tuple[Run, Finding]]) -> list[tuple[Run, Finding]]:
    """Leave out leaps of single channels where the whole record has one."""
    seams = {(run.name, one.end_s) for run, one in found if one.kind == "jump"}
    return [
        (run, one)
        for run, one in found
        if one.kind != "step" or (run.name, one.start_s) not in seams
    ]


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
            word = {"saturated": "at the end of its range"}.get(kind, kind)
            text = f"{column}: {word} {len(members)} times, {minutes:.0f} min, in {listed(names)}"
        fault = _fault(kind, column, names, text)
        spans = tuple(
            Span(run.name, one.start_s, one.end_s, f"{_signal(column)} in {run.name}: {one.text}")
            for run, one in members
            if kind in GROSS
        )
        if kind == "jump":
            # What was joined on is another recording: not what this run's drive did. With samples
            # far apart, a switch makes half of all thermometers jump too.
            spans = tuple(
                Span(run.name, one.end_s, float(run.time_s[-1]), f"{run.name}: {one.text}")
                for run, one in members
                if not near_switch(run)[np.searchsorted(run.time_s, one.end_s)]
            )
        faults.append(replace(fault, spans=spans))
    return faults


def _signal(column: str) -> str:
    return split_column(column)[0]


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
        text = f"{column}: jumps by up to {largest:+.0f} um on coming back, in {listed(names)}"
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
            f"samples, in {listed(names)}"
        )
        faults.append(_fault("staircase", name, names, text))
    return faults
