"""Run the gap finder on many cases: ``python -m benchmarks.gap.run --split reported --out D``.

Each question is written to one JSON file in ``D/records/``, always complete. Questions that already
have a record are skipped, so a stopped run can be continued. ``D/cases`` contains the cases,
``D/answers`` what is hidden in them. The gap finder only sees a case's runs and its owner's file;
what is hidden is added to the record afterwards. ``python -m benchmarks.gap.table D`` makes the
tables.
"""

from __future__ import annotations

import argparse
import json
import os
import sys
import traceback
from collections.abc import Callable, Iterator
from concurrent.futures import ProcessPoolExecutor, as_completed
from functools import partial
from pathlib import Path
from typing import Any

from tqdm import tqdm

from benchmarks.gap.ask import ask, ask_empty, finder_version
from benchmarks.gap.hidden import SIZES
from benchmarks.gap.make import case_folder, write_case
from benchmarks.gap.plan import EMPTY, SPLITS, TRIALS, Planned, balanced, trials
from benchmarks.gap.truths import TRUTHS, USUAL
from measurement.files import write_atomically

RECORDS = "records"

Work = Callable[[list[Planned]], None]
Tried = Callable[[list[Planned]], tuple[int, str]]


def record_path(planned: Planned, out: Path) -> Path:
    """Return the path of a question's record."""
    return out / RECORDS / f"{planned.name}.json"


def ask_case(asked: list[Planned], out: Path, split: str, *, empty: bool) -> None:
    """Ask all questions about one case that have no record yet."""
    questions = [*asked]
    if empty and asked[0].kind != "none":
        questions.insert(0, asked[0].emptied())
    for planned in questions:
        if not record_path(planned, out).exists():
            answer = json.loads(write_case(planned, out).read_text())
            runs = case_folder(planned, out)
            told = ask_empty(runs) if planned.kind == EMPTY else ask(runs, planned.without)
            _write(planned, out, split, answer, told)


def _write(
    planned: Planned, out: Path, split: str, answer: dict[str, Any], told: dict[str, Any]
) -> None:
    """Write the answer together with the truth."""
    record = {
        "name": planned.name,
        "simulator": planned.truth,
        "number": planned.number,
        "split": split,
        "kind": planned.kind,
        "without": list(planned.without),
        "truth": answer["effects"],
        "mistakes": answer["mistakes"],
        "finder": finder_version(),
        **told,
    }
    write_atomically(record_path(planned, out), json.dumps(record, indent=1) + "\n")


def main(arguments: list[str] | None = None) -> int:
    """Ask about the chosen cases in parallel, with a progress bar."""
    args = _parser().parse_args(arguments)
    if args.cases < 1 or args.workers < 1:
        _parser().error("--cases and --workers: 1 or more")
    try:
        cases = (
            balanced(args.split, args.each, args.truth)
            if args.each
            else trials(
                args.split,
                args.cases,
                kinds=args.kind or TRIALS,
                effect=args.effect,
                size=args.size,
                truth=args.truth,
            )
        )
    except ValueError as error:
        _parser().error(str(error))
    if args.numbers:
        cases = [asked for asked in cases if asked[0].number in args.numbers]
    finder_version()  # Cached now, in case the source files change while cases run.
    work = partial(ask_case, out=args.out, split=args.split, empty=not args.no_empty)
    return 1 if _all_of(cases, work, args.workers) else 0


def _all_of(cases: list[list[Planned]], work: Work, workers: int) -> int:
    """Work on all cases, report those that fail, and return their number."""
    failed = 0
    with tqdm(total=len(cases), unit="case") as bar:
        for number, trace in _done(cases, partial(_tried, work), workers):
            bar.update()
            if trace:
                failed += 1
                bar.write(f"case {number:04d} failed:\n{trace}", file=sys.stderr)
    return failed


def _done(cases: list[list[Planned]], work: Tried, workers: int) -> Iterator[tuple[int, str]]:
    if workers == 1:
        yield from map(work, cases)
        return
    with ProcessPoolExecutor(workers) as pool:
        jobs = [pool.submit(work, asked) for asked in cases]
        yield from (job.result() for job in as_completed(jobs))


def _tried(work: Work, asked: list[Planned]) -> tuple[int, str]:
    """Work on one case; return its number and the traceback, if it failed."""
    try:
        work(asked)
    except Exception:
        return asked[0].number, traceback.format_exc()
    return asked[0].number, ""


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="benchmarks.gap.run", description=__doc__)
    parser.add_argument("--split", choices=SPLITS, required=True)
    parser.add_argument("--truth", choices=TRUTHS, default=USUAL, help=f"simulator ({USUAL})")
    parser.add_argument("--cases", type=int, default=143, help="how many (143, one of everything)")
    parser.add_argument("--each", type=int, metavar="N", help="instead: N of each kind and size")
    parser.add_argument("--out", type=Path, required=True, metavar="DIR", help="made or gone on in")
    parser.add_argument("--kind", nargs="+", choices=TRIALS, help="only questions of these kinds")
    parser.add_argument("--effect", help="only cases with this effect")
    parser.add_argument("--size", choices=SIZES, help="only cases with an effect of this size")
    parser.add_argument("--numbers", nargs="+", type=int, metavar="N", help="only these cases")
    parser.add_argument("--workers", type=int, default=os.cpu_count(), help="processes")
    parser.add_argument(
        "--no-empty", action="store_true", help="do not calibrate the same machine and runs empty"
    )
    return parser


if __name__ == "__main__":
    sys.exit(main())
