"""The tables of the gap finder's benchmark, as Markdown."""

from __future__ import annotations

import statistics
from collections import Counter
from collections.abc import Sequence
from functools import partial
from itertools import chain

from statsmodels.stats.proportion import proportion_confint

from benchmarks.gap.outcome import (
    BOTH,
    FALSE,
    HOLDING,
    MORE,
    NAMED,
    ONE_OF,
    RIGHT,
    SAME,
    WRONG,
)
from benchmarks.gap.plan import TRIALS
from benchmarks.gap.records import CLASSES, VISIBLE, Record
from benchmarks.results_page import as_table

CLOSED = 0.8
"""Share of the reducible gap that a correctly named effect should close [1]."""

FIGURES = {
    "Falsely named, nothing missing": "at most 2 %",
    "Falsely named, effect deleted from the catalogue": "at most 10 %",
    "... and not marked as in doubt": "at most 10 %",
    "Falsely named, effect in no catalogue": "at most 10 %",
    "... of these two: same thing in other words": "",
    "Named right, strong effect": "at least 90 %",
    "Named wrong, strong effect": "at most 3 %",
    "Named right, effect larger than usual": "at least 80 %",
    "Mistake of the machine's file: kind and place right": "at least 75 %",
    "... or among others that the runs cannot exclude": "",
    "Both of a pair named, and nothing else": "at least 50 %",
    "Named wrong, weaker effect": "at most 10 %",
    "Truth in the answer, if one is given, or in its set": "at least 97 %",
    "Nothing false in an answer with a name and not in doubt": "at least 95 %",
    "... with a name and in doubt": "",
    "Reducible gap closed on the held-out run, named right: median": "at least 80 %",
    "... cases that close 80 % of it": "",
    "Processor seconds a case: median": "under 60 (30 s on two cores)",
}
"""What is asked of the gap finder, and its target."""


markdown = partial(as_table, flush="---:")
"""A table with all columns except the first aligned right."""


def share(some: int, of: int) -> str:
    """Return a share with its count."""
    return f"{some} of {of} ({100.0 * some / of:.0f} %)" if of else "-"


def bounded(some: Sequence[Record], *outcomes: str, even_in_doubt: bool = True) -> str:
    """Return the share of records with some outcomes, with its 95 % interval (Wilson)."""
    if not some:
        return "-"
    kept = [one for one in with_outcome(some, *outcomes) if even_in_doubt or not one.in_doubt]
    low, high = proportion_confint(len(kept), len(some), method="wilson")
    return f"{share(len(kept), len(some))}; {100.0 * low:.0f} to {100.0 * high:.0f} %"


def median(values: Sequence[float], form: str = "{:.2f}") -> str:
    """Return a median, or a dash."""
    return form.format(statistics.median(values)) if values else "-"


def of_kind(records: Sequence[Record], *kinds: str) -> list[Record]:
    """Return the records of some kinds."""
    return [one for one in records if one.kind in kinds]


def with_outcome(records: Sequence[Record], *outcomes: str) -> list[Record]:
    """Return the records with some outcomes."""
    return [one for one in records if one.outcome in outcomes]


def named_right(records: Sequence[Record]) -> list[Record]:
    """Return the records named right whose gap can be reduced at all."""
    found = with_outcome(of_kind(records, "effect"), RIGHT)
    return [one for one in found if one.ratio >= VISIBLE]


def targets(records: Sequence[Record]) -> str:
    """Return the figures that the gap finder is judged by, next to their targets."""
    return markdown(["", "Target", "Found; 95 % interval"], _target_rows(records))


def by_simulator(folders: Sequence[Sequence[Record]]) -> str:
    """Return the same over all records in *folders* and for each simulator."""
    names = ["all", *(some[0].simulator for some in folders)]
    folders = [list(chain.from_iterable(folders)), *folders]
    rows = [_target_rows(some) for some in folders]
    counts = [str(len(some)) for some in folders]
    fingers = [", ".join(sorted({one.table["finder"] for one in some})) for some in folders]
    body = [[*one[:2], *(other[i][2] for other in rows)] for i, one in enumerate(rows[0])]
    body += [["Questions", "", *counts], ["Fingerprint of the gap finder", "", *fingers]]
    return markdown(["", "Target", *names], body)


def _target_rows(records: Sequence[Record]) -> list[list[str]]:
    """Return the rows of figure, target and result."""
    none, single, beyond, outside, deleted, mistakes, pairs = (
        of_kind(records, kind)
        for kind in ("none", "effect", "beyond", "outside", "deleted", "mistake", "pair")
    )
    strong = [one for one in single if one.strength == "strong"]
    others = [one for one in single if one.strength != "strong"]
    told = with_outcome(single, RIGHT, ONE_OF, WRONG, MORE)
    naming = with_outcome(records, *HOLDING, *FALSE)
    sure, in_doubt = ([one for one in naming if one.in_doubt is it] for it in (False, True))
    reducible = named_right(records)
    found = [
        bounded(none, NAMED),
        bounded(deleted, NAMED),
        bounded(deleted, NAMED, even_in_doubt=False),
        bounded(outside, NAMED),
        bounded([*deleted, *outside], SAME),
        bounded(strong, RIGHT),
        bounded(strong, WRONG, MORE),
        bounded(beyond, RIGHT),
        bounded(mistakes, RIGHT),
        bounded(mistakes, RIGHT, ONE_OF),
        bounded(pairs, BOTH),
        bounded(others, WRONG, MORE),
        bounded(told, RIGHT, ONE_OF, MORE),
        bounded(sure, *HOLDING),
        bounded(in_doubt, *HOLDING),
        median([100.0 * one.closed for one in reducible], "{:.0f} %"),
        share(sum(one.closed >= CLOSED for one in reducible), len(reducible)),
        median([one.table["seconds"]["cpu"] for one in records], "{:.0f}"),
    ]
    return [[*figure, text] for figure, text in zip(FIGURES.items(), found, strict=True)]


def outcomes(records: Sequence[Record]) -> str:
    """Return how often each outcome occurs, by kind of question and strength of the case.

    In a strong case, the gap of the calibrated model is at least `STRONG` times the gap with
    nothing hidden, in a visible one `VISIBLE` times.
    """
    counted = Counter((one.kind, one.strength, one.outcome) for one in records)
    heads = sorted({outcome for *_, outcome in counted})
    rows = []
    for kind in TRIALS:
        for strength in CLASSES:
            counts = [counted[kind, strength, outcome] for outcome in heads]
            if sum(counts):
                rows.append([kind, strength, str(sum(counts)), *(str(n or "") for n in counts)])
    return markdown(["Kind", "Strength", "Cases", *heads], rows)


def false_names(records: Sequence[Record]) -> str:
    """Return every case with a wrong name, one per row."""
    wrong = with_outcome(records, *FALSE)
    rows = [
        [
            one.name,
            one.kind,
            " + ".join(_missing(one)) or "nothing",
            f"{one.ratio:.2f}",
            " + ".join(" or ".join(group) for group in one.groups),
        ]
        for one in sorted(wrong, key=lambda one: (one.kind, one.name))
    ]
    if not rows:
        return "None."
    return markdown(["Case", "Kind", "Hidden", "Times the gap of nothing", "Named"], rows)


def _missing(record: Record) -> list[str]:
    found = [_hidden(effect) for effect in record.truth]
    return found + [f"in the file: {m['kind']}:{'+'.join(m['place'])}" for m in record.mistakes]


def _hidden(effect: dict[str, str]) -> str:
    return ":".join(filter(None, (effect["name"], effect["channel"]))) + f" ({effect['size']})"
