"""Formats faults as text, in the same words for every command."""

from __future__ import annotations

from collections.abc import Sequence

from measurement.faults.fault import Fault
from measurement.faults.kinds import HANDLING, LEVELS
from measurement.runs import TIME


def by_column(faults: Sequence[Fault]) -> list[list[Fault]]:
    """Return faults grouped by kind and column, in the order in which they are reported.

    Parameters
    ----------
    faults : sequence of Fault
        Of any runs, in any order.
    """
    groups: dict[tuple[str, str], list[Fault]] = {}
    for fault in sorted(faults, key=_rank):
        groups.setdefault((fault.kind, fault.column), []).append(fault)
    return list(groups.values())


def faults_text(faults: Sequence[Fault]) -> str:
    """Return faults as lines: a single one in full, several of a kind and column by the longest.

    Parameters
    ----------
    faults : sequence of Fault
        May be empty; the text then says so.
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
    example = f"{longest.run}, {longest.when()}: {longest.text}"
    return f"{head}; the longest: {example}; {longest.handling}"


def _rank(fault: Fault) -> tuple[bool, int]:
    """Return the rank in which a fault is reported: those of the whole record last."""
    return fault.column == TIME, list(HANDLING).index(fault.kind)
