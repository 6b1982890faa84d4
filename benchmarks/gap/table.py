"""Tables of a folder of records: ``python -m benchmarks.gap.table DIR``.

Prints the tables and writes them to ``DIR/tables.md``. ``--beside DIR`` adds folders of other
simulators and instead prints one table with a column for each, which ``--docs`` writes into
``docs/gap_benchmark.md``.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Sequence
from pathlib import Path

from benchmarks.gap import sections
from benchmarks.gap.records import Record, read_records
from benchmarks.gap.run import RECORDS
from benchmarks.results_page import put
from measurement.errors import BadInput
from measurement.files import write_atomically

PAGE = Path(__file__).resolve().parents[2] / "docs" / "gap_benchmark.md"

TABLES: dict[str, Callable[[Sequence[Record]], str]] = {
    "What is asked of the gap finder": sections.targets,
    "What was said": sections.outcomes,
    "Every wrong name": sections.false_names,
}


def text_of(records: Sequence[Record]) -> str:
    """Return all tables."""
    tables = [one.table for one in records]
    splits = sorted({one["split"] for one in tables})
    versions = sorted({one["finder"] for one in tables})
    empty = sum(one.matched for one in records)
    parts = [
        f"Split: {', '.join(splits)}. {len(records)} questions on "
        f"{len({one['number'] for one in tables})} cases; {empty} of them beside the same machine "
        f"and runs with nothing hidden. Fingerprint of the gap finder: {', '.join(versions)}."
    ]
    parts += [f"### {title}\n\n{table(records)}" for title, table in TABLES.items()]
    return "\n\n".join(parts) + "\n"


def main(arguments: list[str] | None = None) -> int:
    """Print the tables and write them."""
    parser = argparse.ArgumentParser(prog="benchmarks.gap.table", description=__doc__)
    parser.add_argument("folder", type=Path, metavar="DIR", help="that benchmarks.gap.run wrote")
    parser.add_argument("--docs", action="store_true", help="write the documentation, too")
    parser.add_argument(
        "--beside", nargs="+", type=Path, metavar="DIR", help="folders of other simulators"
    )
    args = parser.parse_args(arguments)
    if args.docs and not args.beside:
        parser.error("--docs: the page has the table of several simulators; name them (--beside)")
    try:
        read = [read_records(one / RECORDS) for one in (args.folder, *(args.beside or ()))]
    except BadInput as error:
        parser.error(str(error))
    text = sections.by_simulator(read) if args.beside else text_of(*read)
    print(text)
    if args.docs:
        put("simulators", text, PAGE)
    elif not args.beside:
        write_atomically(args.folder / "tables.md", text)
    return 0


if __name__ == "__main__":
    sys.exit(main())
