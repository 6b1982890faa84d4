"""Tables and figures of a folder of records: ``python -m benchmarks.gap.table DIR [--docs]``.

Prints the tables and writes them to ``DIR/tables.md``, the figures beside it. With ``--docs`` they
go into ``docs/gap_benchmark.md`` and ``docs/figures``, too. ``--beside DIR`` adds folders of other
simulators: of these, one table with a column for each is made, and with ``--docs`` it comes first
on that page, and nothing else of it is changed.
"""

from __future__ import annotations

import argparse
import re
import sys
from collections.abc import Callable, Sequence
from pathlib import Path

from benchmarks.gap import sections
from benchmarks.gap.contest import FINDER, contest
from benchmarks.gap.figures import confusion_matrix, naming_by_size, strong_confusion_matrix
from benchmarks.gap.records import Record, read_records
from benchmarks.gap.run import RECORDS, RIVALS
from measurement.errors import BadInput
from measurement.files import write_atomically

DOCS = Path(__file__).resolve().parents[2] / "docs"
PAGE = "gap_benchmark.md"
MARKS = {
    name: re.compile(rf"(<!-- begin {name}[^\n]*-->\n).*?(<!-- end {name} -->)", re.DOTALL)
    for name in ("results", "simulators")
}

TABLES: dict[str, Callable[[Sequence[Record]], str]] = {
    "What is asked of the gap finder": sections.targets,
    "One effect missing": sections.single_effects,
    "Nothing of the catalogue missing": sections.open_set,
    "Two effects missing": sections.pairs,
    "A mistake in the machine's file": sections.mistakes,
    "The gap on the held-out run": sections.gaps,
    "Amplitudes of effects named right": sections.amplitudes,
    "Every wrong name": sections.false_names,
}
FIGURES = {
    "gap_confusion": ("Confusion matrix, effects of all sizes", confusion_matrix),
    "gap_confusion_strong": ("Confusion matrix, strong effects", strong_confusion_matrix),
    "gap_naming": ("What is said against the gap that the effect leaves", naming_by_size),
}


def text_of(records: Sequence[Record], rivals: dict[str, Sequence[Record]], figures: str) -> str:
    """Return all tables, with links to the figures in a folder.

    *rivals* holds the records of other methods by their titles.
    """
    tables = [one.table for one in records]
    usual = at_usual_noise(records)
    splits = sorted({one["split"] for one in tables})
    versions = sorted({one["finder"] for one in tables})
    empty = sum(one.matched for one in records)
    parts = [
        f"Split: {', '.join(splits)}. {len(records)} questions on "
        f"{len({one['number'] for one in tables})} cases; {empty} of them beside the same machine "
        f"and runs with nothing hidden. Fingerprint of the gap finder: {', '.join(versions)}."
    ]
    parts += [f"### {title}\n\n{table(usual)}" for title, table in TABLES.items()]
    parts.append(f"### Against noise\n\n{sections.against_noise(records)}")
    parts.append(f"### Beside other methods\n\n{contest({FINDER: usual} | rivals)}")
    parts += [f"![{title}]({figures}{name}.png)" for name, (title, _) in FIGURES.items()]
    return "\n\n".join(parts) + "\n"


def at_usual_noise(records: Sequence[Record]) -> list[Record]:
    """Return the records whose sensors have their usual noise; all if there are none."""
    return [one for one in records if one.noise == 1.0] or list(records)


def read_rivals(folder: Path) -> dict[str, Sequence[Record]]:
    """Return the records of every rival that was asked, by its title."""
    found = {}
    for asked in sorted(path for path in (folder / RIVALS).glob("*") if path.is_dir()):
        records = read_records(asked, folder / RECORDS)
        found[str(records[0].table.get("method", asked.name))] = records
    return found


def write_figures(records: Sequence[Record], folder: Path) -> None:
    """Write the figures, of the usual noise."""
    for name, (_, draw) in FIGURES.items():
        write_atomically(folder / f"{name}.png", draw(at_usual_noise(records)))


def _of_all(folders: Sequence[Path], *, docs: bool) -> int:
    """Print the table of several simulators, one folder each."""
    some = [at_usual_noise(read_records(folder / RECORDS)) for folder in folders]
    text = sections.by_simulator(some)
    print(text)
    if docs:
        into_page("simulators", text)
    return 0


def main(arguments: list[str] | None = None) -> int:
    """Print the tables and write them."""
    parser = argparse.ArgumentParser(prog="benchmarks.gap.table", description=__doc__)
    parser.add_argument("folder", type=Path, metavar="DIR", help="that benchmarks.gap.run wrote")
    parser.add_argument("--docs", action="store_true", help="write the documentation, too")
    parser.add_argument(
        "--beside", nargs="+", type=Path, metavar="DIR", help="folders of other simulators"
    )
    args = parser.parse_args(arguments)
    try:
        if args.beside:
            return _of_all([args.folder, *args.beside], docs=args.docs)
        records, rivals = read_records(args.folder / RECORDS), read_rivals(args.folder)
    except BadInput as error:
        parser.error(str(error))
    text = text_of(records, rivals, "")
    print(text)
    write_atomically(args.folder / "tables.md", text)
    write_figures(records, args.folder)
    if args.docs:
        write_figures(records, DOCS / "figures")
        into_page("results", text_of(records, rivals, "figures/"))
    return 0


def into_page(name: str, text: str) -> None:
    """Put a text between the marks of a name on the page."""
    page = (DOCS / PAGE).read_text(encoding="utf-8")
    write_atomically(DOCS / PAGE, MARKS[name].sub(lambda f: f"{f[1]}\n{text}\n{f[2]}", page))


if __name__ == "__main__":
    sys.exit(main())
