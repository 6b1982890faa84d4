"""Whether the answer stays when the same runs are recorded otherwise.

``python -m benchmarks.gap.same_answer --split development --cases 6 --out DIR`` asks about cases
with one effect hidden, as recorded (every 20 to 60 s), thinned to 60 s and 240 s, with a tenth of
the rows dropped at random, and with the runs in another order.
"""

from __future__ import annotations

import argparse
import json
import os
import sys
from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from pathlib import Path
from typing import Any

from tqdm import tqdm

from benchmarks.gap.ask import MACHINE, runs_of
from benchmarks.gap.make import case_folder, write_case
from benchmarks.gap.plan import SPLITS, Planned, plan
from benchmarks.gap.truth.effects.base import SIZES
from benchmarks.gap.variants import variants
from gap_finder.find import find_gap
from gap_finder.search import Search
from measurement.files import write_atomically
from measurement.runs import Run
from plant_model.machine_file import read_machine
from scenarios.gap_runner import usable_runs

THINNED_S = (60.0, 240.0)


def ways(runs: Sequence[Run], seed: int) -> Iterator[tuple[str, list[Run]]]:
    """Return the runs in every way in which they are asked about."""
    yield from variants(runs, seed, THINNED_S)
    # The order of the files is the order of their names to the gap finder, so names change, too.
    again = [Run(f"z{len(runs) - i}", run.frame) for i, run in enumerate(runs)]
    yield "renamed, last first", again[::-1]


def answers(planned: Planned, out: Path) -> dict[str, Any]:
    """Return what is said of a case in every way."""
    write_case(planned, out)
    runs, _ = runs_of(case_folder(planned, out))
    machine = read_machine(MACHINE)
    said = {}
    for way, some in ways(runs, planned.number):
        used, _, _ = usable_runs(machine, some)
        found = find_gap(machine, used, Search(workers=1))
        named = [sorted(selection.one_of) for selection in found.rounds if selection.named]
        said[way] = {"verdict": found.verdict, "named": named}
    return {"case": planned.name, "hidden": list(planned.case.hidden), "said": said}


def main(arguments: list[str] | None = None) -> int:
    """Ask, write ``same_answer.json``, and print what differs."""
    parser = argparse.ArgumentParser(prog="benchmarks.gap.same_answer", description=__doc__)
    parser.add_argument("--split", choices=SPLITS, required=True)
    parser.add_argument("--cases", type=int, default=6, help="how many (6)")
    parser.add_argument("--size", choices=SIZES, default="strong", help="of the effect (strong)")
    parser.add_argument("--out", type=Path, required=True, metavar="DIR")
    parser.add_argument("--workers", type=int, default=os.cpu_count(), help="processes")
    args = parser.parse_args(arguments)
    cases = plan(args.split, args.cases, kind="effect", size=args.size)
    told = []
    with ProcessPoolExecutor(args.workers) as pool:
        jobs = [pool.submit(answers, planned, args.out) for planned in cases]
        for job in tqdm(as_completed(jobs), total=len(jobs), unit="case"):
            told.append(job.result())
            text = json.dumps(sorted(told, key=lambda one: one["case"]), indent=1) + "\n"
            write_atomically(args.out / "same_answer.json", text)
    total = same = 0
    for one in sorted(told, key=lambda one: one["case"]):
        said = one["said"]
        first = said.pop("as recorded")
        other = {way: answer for way, answer in said.items() if answer != first}
        total, same = total + len(said), same + len(said) - len(other)
        print(f"{one['case']}  hidden {one['hidden'][0][0]}: {_text(first)}")
        for way, answer in other.items():
            print(f"      {way}: {_text(answer)}")
    print(f"the same answer in {same} of {total}")
    return 0


def _text(answer: dict[str, Any]) -> str:
    named = " and ".join(" or ".join(group) for group in answer["named"])
    return f"{answer['verdict']} {named}".strip()


if __name__ == "__main__":
    sys.exit(main())
