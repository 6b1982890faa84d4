"""The gap finder beside other methods, on the questions that all of them were asked."""

from __future__ import annotations

import statistics
from collections.abc import Sequence

from benchmarks.gap.outcome import MORE, NAMED, RIGHT, holds
from benchmarks.gap.records import Record
from benchmarks.gap.sections import markdown, median, of_kind, share, with_outcome

FINDER = "Gap finder"
HEAD = (
    "",
    "nothing missing: falsely named",
    "open set: falsely named",
    "strong: right",
    "right among others",
    "first name right",
    "names a case",
    "gap before",
    "after",
    "closed",
    "seconds (all)",
)


def contest(methods: dict[str, Sequence[Record]]) -> str:
    """Return the table of all methods by title; questions that one was not asked are left out."""
    if len(methods) < 2:
        return "No other method was asked."
    common = set.intersection(*({one.name for one in some} for some in methods.values()))
    if not common:
        return "No question was put to all methods."
    rows = [
        _row(title, [one for one in some if one.name in common]) for title, some in methods.items()
    ]
    told = (
        f"{len(common)} questions that all were asked; all but the first two columns and the last"
    )
    return f"{told} are of strong effects.\n\n{markdown(HEAD, rows)}"


def _row(title: str, records: list[Record]) -> list[str]:
    none, open_set = of_kind(records, "none"), of_kind(records, "deleted", "outside")
    strong = [one for one in of_kind(records, "effect") if one.strength == "strong"]
    first = [one for one in strong if one.groups and holds(one.groups[0], one.truth[0])]
    gaps = [one.answer["gap"]["holdout"] for one in strong]
    names = [float(sum(map(len, one.groups))) for one in strong]
    return [
        title,
        share(len(with_outcome(none, NAMED)), len(none)),
        share(len(with_outcome(open_set, NAMED)), len(open_set)),
        share(len(with_outcome(strong, RIGHT)), len(strong)),
        share(len(with_outcome(strong, MORE)), len(strong)),
        share(len(first), len(strong)),
        f"{statistics.mean(names):.1f}" if names else "-",
        median([gap["before"] for gap in gaps]),
        median([gap["after"] for gap in gaps]),
        median([100.0 * one.closed for one in strong], "{:.0f} %"),
        median([one.table["seconds"]["cpu"] for one in records], "{:.0f}"),
    ]
