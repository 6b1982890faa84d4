"""Write the cases: ``python -m benchmarks.gap.make --split development --cases 50 --out DIR``.

``DIR/cases/NNNN/`` holds run_1.csv to run_4.csv and holdout.csv, the machine's file as its owner
writes it where the truth (``--truth``) has an owner, and nothing about what is hidden;
``DIR/answers/NNNN.json`` holds that. A case whose answer is there is not made again.
"""

from __future__ import annotations

import argparse
import json
import os
import sys
from concurrent.futures import ProcessPoolExecutor, as_completed
from pathlib import Path
from typing import Any

from tqdm import tqdm

from benchmarks.gap.hidden import SIZES
from benchmarks.gap.plan import KINDS, SPLITS, Planned, plan
from benchmarks.gap.truths import TRUTHS, USUAL
from measurement.files import write_atomically
from measurement.runs import write_run

OWNERS_FILE = "machine.toml"


def case_folder(planned: Planned, out: Path) -> Path:
    """Return where the runs of a case are written."""
    return out / "cases" / planned.files


def write_case(planned: Planned, out: Path) -> Path:
    """Write one case's runs and its answer; return the answer's path."""
    answer = out / "answers" / f"{planned.files}.json"
    if answer.exists():
        return answer
    folder = case_folder(planned, out)
    folder.mkdir(parents=True, exist_ok=True)
    answer.parent.mkdir(parents=True, exist_ok=True)
    truth = TRUTHS[planned.truth]
    runs, effects = truth.simulate(planned.case)
    for run in runs:
        write_run(run.frame, folder / f"{run.name}.csv")
    if truth.page is not None:
        write_atomically(folder / OWNERS_FILE, truth.page(planned.case))
    mistake = truth.shop.mistakes.get(planned.case.mistake)
    table: dict[str, Any] = {
        "number": planned.number,
        "kind": planned.kind,
        "seed": planned.case.seed,
        "effects": [
            {
                "name": effect.name,
                "channel": effect.channel,
                "size": size,
                "amplitude": effect.size,
                "unit": effect.unit,
                "more": effect.more,
                "catalogued": effect.catalogued,
                "in_other_words": [
                    {"kind": kind, "place": list(place)} for kind, place in effect.in_other_words
                ],
            }
            for effect, (_, size, _) in zip(effects, planned.case.hidden, strict=True)
        ],
        "mistakes": []
        if mistake is None
        else [{"kind": mistake.kind, "place": list(mistake.place)}],
        "families": [run.drive.family for run in runs],
    }
    # The answer comes last: where it stands, the case is whole.
    return write_atomically(answer, json.dumps(table, indent=1) + "\n")


def main(arguments: list[str] | None = None) -> int:
    """Write the cases asked for, on all cores, with a progress bar."""
    parser = argparse.ArgumentParser(prog="benchmarks.gap.make", description=__doc__)
    parser.add_argument("--split", choices=SPLITS, required=True)
    parser.add_argument("--truth", choices=TRUTHS, default=USUAL, help=f"simulator ({USUAL})")
    parser.add_argument("--cases", type=int, required=True, help="how many")
    parser.add_argument("--out", type=Path, required=True, help="folder to write into")
    parser.add_argument("--kind", choices=KINDS, help="only cases of this kind")
    parser.add_argument("--effect", help="only cases with this effect")
    parser.add_argument("--size", choices=SIZES, help="only cases with an effect of this size")
    parser.add_argument("--workers", type=int, default=os.cpu_count(), help="processes")
    args = parser.parse_args(arguments)
    try:
        cases = plan(
            args.split,
            args.cases,
            kind=args.kind,
            effect=args.effect,
            size=args.size,
            truth=args.truth,
        )
    except ValueError as error:
        parser.error(str(error))
    if args.workers <= 1:
        for planned in tqdm(cases, unit="case"):
            write_case(planned, args.out)
        return 0
    with ProcessPoolExecutor(args.workers) as pool:
        jobs = [pool.submit(write_case, planned, args.out) for planned in cases]
        for job in tqdm(as_completed(jobs), total=len(jobs), unit="case"):
            job.result()
    return 0


if __name__ == "__main__":
    sys.exit(main())
