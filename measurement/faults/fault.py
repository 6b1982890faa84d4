"""One thing that is wrong with the data, in the words that every command uses."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Any

HANDLING = {
    "frozen": "this time of the channel is left out",
    "saturated": "this time of the channel is left out",
    "dead": "this time of the channel is left out",
    "spikes": "this time of the channel is left out",
    "step": "this time of the channel is left out",
    "runaway": "this time of the channel is left out",
    "jump": "the record is used up to there",
    "level_jump": "not used where levels count; rises do not feel it",
    "never_right": "not used where levels count; rises do not feel it",
    "restart": "kept: the reading is right again after it",
    "staircase": "kept: no error below the step can be told",
    "absent": "nothing that needs it is stated",
    "missing": "gaps of up to five usual intervals are bridged, longer ones left out",
    "pause": "kept: models go by time, not by rows",
}
"""Kinds of faults, the gravest first where the data are not to be used, and what is done."""

GROSS = ("saturated", "frozen", "dead", "runaway", "step", "spikes", "jump")
"""Kinds whose time is not to be used: what was read then is not what the machine did."""
LEVELS = ("level_jump", "never_right")
"""Kinds of a thermometer whose level is wrong while its rises may be right."""

_TOLD_IN = ("level_jump", "never_right", *GROSS[:-1], "restart", "staircase")
_ORDER = (*_TOLD_IN, "absent", "missing", "pause", "jump")


@dataclass(frozen=True)
class Fault:
    """Something that is wrong with one channel in one span of one run.

    Attributes
    ----------
    run : str
        The run's name.
    column : str
        The channel; ``time_s`` for what befell the whole record.
    kind : str
        One of `HANDLING`.
    start_s, end_s : float
        When [s].
    text : str
        What is wrong, in words.
    place : int
        Which of the runs that were looked at: their names need not differ.
    """

    run: str
    column: str
    kind: str
    start_s: float
    end_s: float
    text: str
    place: int = 0

    @property
    def handling(self) -> str:
        """What is done about it, in words."""
        return HANDLING[self.kind]

    @property
    def is_gross(self) -> bool:
        """Whether this time of the channel is not to be used at all."""
        return self.kind in GROSS

    def line(self) -> str:
        """Return run, column, span, what, and what is done about it."""
        return f"{self.run}, {self.column}, {self._when()}: {self.text}; {self.handling}"

    def _when(self) -> str:
        start, end = self.start_s / 60.0, self.end_s / 60.0
        # One reading, or a span too short to have two ends in minutes.
        return f"at {start:.0f} min" if end - start < 0.5 else f"{start:.0f} to {end:.0f} min"

    def to_dict(self) -> dict[str, Any]:
        """Return the fault as a plain dict, without the place."""
        table = asdict(self) | {"handling": self.handling}
        del table["place"]
        return table


def by_column(faults: Sequence[Fault]) -> list[list[Fault]]:
    """Return faults of one kind and column together, in the order in which they are told.

    Parameters
    ----------
    faults : sequence of Fault
        Of any runs, in any order.
    """
    groups: dict[tuple[str, str], list[Fault]] = {}
    for fault in sorted(faults, key=lambda fault: _ORDER.index(fault.kind)):
        groups.setdefault((fault.kind, fault.column), []).append(fault)
    return list(groups.values())


def faults_text(faults: Sequence[Fault]) -> str:
    """Return faults as lines: one alone in full, several of a kind and column by the longest.

    Parameters
    ----------
    faults : sequence of Fault
        May be empty, which is said in words.
    """
    if not faults:
        return "  nothing that these checks see"
    return "\n".join(f"  {group_line(group)}" for group in by_column(faults))


def group_line(group: Sequence[Fault]) -> str:
    """Return one line for faults of one kind and column.

    Parameters
    ----------
    group : sequence of Fault
        One or more, all of one kind and column, as `by_column` groups them.
    """
    if len(group) == 1:
        return group[0].line()
    longest = max(group, key=lambda fault: fault.end_s - fault.start_s)
    minutes = sum(fault.end_s - fault.start_s for fault in group) / 60.0
    names = list(dict.fromkeys(fault.run for fault in group))
    runs = ", ".join(names)
    if len(names) > 3:
        runs = f"{len(names)} runs ({names[0]} ... {names[-1]})"
    head = f"{longest.column}, {longest.kind} {len(group)} times, {minutes:.0f} min, in {runs}"
    if longest.kind in LEVELS:
        head = f"{longest.column}, {longest.kind} in {runs}"
    example = f"{longest.run}, {longest._when()}: {longest.text}"
    return f"{head}; the longest: {example}; {longest.handling}"
