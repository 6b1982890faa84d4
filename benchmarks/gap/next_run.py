"""Whether the run that the gap finder asks for tells: ``python -m benchmarks.gap.next_run DIR``.

DIR is that of ``benchmarks.gap.run``. Every question there whose answer left several names and
asked for a run is asked again twice: with the run asked for, made on the machine of the case, and
with a run of speeds drawn at random. ``DIR/next_run/NNNN.json`` holds what was said; a question
whose file is there is not asked again.
"""

from __future__ import annotations

import argparse
import json
import sys
from collections import Counter
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from tqdm import tqdm

from benchmarks.gap.ask import ask
from benchmarks.gap.outcome import OPEN_OUTCOMES, OUTCOMES, PAIR_OUTCOMES, groups_of, outcome
from benchmarks.gap.plan import case_of
from benchmarks.gap.truths import TRUTHS, USUAL
from measurement.files import write_atomically
from measurement.runs import write_run

FOLDER = "next_run"
ASKED, RANDOM = "asked for", "at random"


def ask_again(record: Mapping[str, Any], out: Path) -> dict[str, Any]:
    """Return what is said of a question with the run asked for, and with one at random."""
    case, further = case_of(record), TRUTHS[record.get("simulator", USUAL)].further
    assert further is not None
    stretches = {
        name: [(float(time), float(value)) for time, value in some]
        for name, some in record["answer"]["next_run"]["stretches"].items()
    }
    said = {}
    for which, held in ((ASKED, stretches), (RANDOM, {})):
        folder = out / FOLDER / f"{record['name']}_{which.replace(' ', '_')}"
        if not folder.exists():
            folder.mkdir(parents=True)
            for path in (out / "cases" / record["name"].removesuffix("_deleted")).iterdir():
                (folder / path.name).write_bytes(path.read_bytes())
        run = further(case, held)
        write_run(run.frame, folder / "run_5.csv")
        answer = ask(folder, record["without"])["answer"]
        groups = groups_of(answer, record.get("mistakes", ()))
        said[which] = {
            "outcome": outcome(record["kind"], record["truth"], groups, answer["verdict"]),
            "verdict": answer["verdict"],
            "named": [list(group) for group in groups],
        }
    return {"name": record["name"], "before": record["answer"]["one_of_keys"], **said}


def main(arguments: list[str] | None = None) -> int:
    """Ask again about every question that asked for a run, and print the table."""
    parser = argparse.ArgumentParser(prog="benchmarks.gap.next_run", description=__doc__)
    parser.add_argument("out", type=Path, metavar="DIR", help="that of benchmarks.gap.run")
    args = parser.parse_args(arguments)
    records = [json.loads(path.read_text()) for path in sorted(args.out.glob("records/*.json"))]
    asking = [
        one
        for one in records
        if one["answer"].get("next_run") and TRUTHS[one.get("simulator", USUAL)].further
    ]
    if not asking:
        parser.error(f"{args.out}: no question there has asked for a run")
    found = []
    for record in tqdm(asking, unit="question"):
        path = args.out / FOLDER / f"{record['name']}.json"
        if not path.exists():
            path.parent.mkdir(exist_ok=True)
            write_atomically(path, json.dumps(ask_again(record, args.out), indent=1) + "\n")
        found.append(json.loads(path.read_text()))
    print(table(found))
    return 0


def table(found: list[Mapping[str, Any]]) -> str:
    """Return how often which outcome came of the run asked for, and of one at random."""
    counts = {which: Counter(one[which]["outcome"] for one in found) for which in (ASKED, RANDOM)}
    known = dict.fromkeys((*OUTCOMES, *PAIR_OUTCOMES, *OPEN_OUTCOMES))
    kinds = [name for name in known if any(count[name] for count in counts.values())]
    lines = [
        "| After one more run | " + " | ".join(kinds) + " |",
        "| --- |" + " ---: |" * len(kinds),
    ]
    for which, count in counts.items():
        lines.append(f"| {which} | " + " | ".join(str(count[name]) for name in kinds) + " |")
    return "\n".join(lines)


if __name__ == "__main__":
    sys.exit(main())
