"""The naming threshold set on all simulators but one, and judged on that one, in turn.

    python -m benchmarks.gap.in_turn DIR DIR DIR [--docs]

Each DIR is that of ``benchmarks.gap.run``. What a first effect must explain to be named
(``selection.LEAST_SHARE``) is set to what would have served best on the other simulators. A record
holds what was named at the threshold in force, so that only stricter ones can be tried. Nothing is
run again. ``--docs`` writes the table into docs/gap_benchmark.md.
"""

from __future__ import annotations

import argparse
import sys
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path

from benchmarks.gap.outcome import BOTH, FIRST, NAMED, ONE_OF, RIGHT, WRONG
from benchmarks.gap.records import Record, read_records
from benchmarks.gap.run import RECORDS
from benchmarks.gap.table import into_page
from gap_finder.selection import LEAST_SHARE

SHARES = (LEAST_SHARE, 0.2, 0.25, 0.3, 0.4, 0.5, 0.6)
"""Thresholds tried [1]."""

COST = 3
"""A wrong name counts like so many right ones that are not given."""

HITS, MISSES = (RIGHT, ONE_OF, BOTH, FIRST), (WRONG, NAMED)


def judged(record: Record, share: float) -> str:
    """Return ``hit``, ``miss`` or ``silent`` for a question if the threshold were *share*.

    Parameters
    ----------
    record : Record
    share : float
        [1]
    """
    (first, *_) = record.table["details"]["rounds"]
    of_catalogue = bool(first["one_of"])
    if of_catalogue and first["explained_share"] < share:
        return "silent"
    if record.outcome in HITS:
        return "hit"
    return "miss" if record.outcome in MISSES else "silent"


def counted(records: Iterable[Record], share: float) -> Counter[str]:
    """Return how often each would be said.

    Parameters
    ----------
    records : iterable of Record
    share : float
        [1]
    """
    return Counter(judged(record, share) for record in records)


def best_share(records: Sequence[Record]) -> float:
    """Return the threshold that serves best, the lowest of equals.

    Parameters
    ----------
    records : sequence of Record
        Of the simulators that it is set on.
    """
    scores = {share: counted(records, share) for share in SHARES}
    return max(
        SHARES, key=lambda share: (scores[share]["hit"] - COST * scores[share]["miss"], -share)
    )


def table(by_simulator: Mapping[str, Sequence[Record]]) -> str:
    """Return the table, a row for each simulator left out.

    Parameters
    ----------
    by_simulator : mapping of str to sequence of Record
    """
    lines = [
        "| Reported on | Questions | Threshold set on the others | named right | wrong or falsely "
        f"| at {LEAST_SHARE:.0%}: right | wrong or falsely |",
        "| --- | ---: | ---: | ---: | ---: | ---: | ---: |",
    ]
    for name, records in by_simulator.items():
        others = [one for other, some in by_simulator.items() if other != name for one in some]
        share = best_share(others)
        there, now = counted(records, share), counted(records, LEAST_SHARE)
        lines.append(
            f"| {name} | {len(records)} | {share:.0%} | {there['hit']} | {there['miss']} "
            f"| {now['hit']} | {now['miss']} |"
        )
    return "\n".join(lines)


def main(arguments: list[str] | None = None) -> int:
    """Read the records, print the table, and put it into the page if that is asked for."""
    parser = argparse.ArgumentParser(prog="benchmarks.gap.in_turn", description=__doc__)
    parser.add_argument("folders", nargs="+", type=Path, metavar="DIR")
    parser.add_argument("--docs", action="store_true", help="write docs/gap_benchmark.md, too")
    args = parser.parse_args(arguments)
    by_simulator: dict[str, list[Record]] = {}
    for folder in args.folders:
        for record in read_records(folder / RECORDS):
            by_simulator.setdefault(record.simulator, []).append(record)
    if len(by_simulator) < 2:
        parser.error("records of two simulators or more are needed")
    text = table(by_simulator)
    print(text)
    if args.docs:
        into_page("in_turn", text)
    return 0


if __name__ == "__main__":
    sys.exit(main())
