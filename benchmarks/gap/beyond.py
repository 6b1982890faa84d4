"""Effects larger than usual: ``python -m benchmarks.gap.beyond --split reported --out DIR``.

The truth has no ranges: here it hides effects two to four times as large as the usual range of the
catalogue goes. Each is asked for twice, the second time without that effect in the catalogue, so
that the right answer is *unknown*. ``DIR/beyond.json`` holds the answers; one line is printed for
each. The machines and runs are none of the other benchmark's.
"""

from __future__ import annotations

import argparse
import json
import sys
import tempfile
from pathlib import Path
from typing import Any

from benchmarks.gap.ask import ask
from benchmarks.gap.plan import SPLITS
from benchmarks.gap.truth.case import TruthCase, simulate_case
from measurement.files import write_atomically
from measurement.runs import write_run

FIRST = 900_000
"""Seeds are this far from those of the other cases of a split."""

HIDDEN: dict[str, float] = {
    "windage": 900.0,
    "motor_iron_loss": 2500.0,
    "coolant_supply_offset": 5.0,
    "column_bending": 110.0,
    "centrifugal_shift": 80.0,
    "forced_convection": 12.0,
    "fixture_warming": 16.0,
    "slow_structure": 90.0,
    "sensor_lag": 50.0,
    "sensor_drift": 8.0,
}
"""What is hidden, in the unit of the truth's amplitude."""


def asked(name: str, seed: int, without: tuple[str, ...] = ()) -> dict[str, Any]:
    """Hide an effect, ask, and return the answer in short."""
    runs, effects = simulate_case(TruthCase(seed, ((name, HIDDEN[name], ""),)))
    with tempfile.TemporaryDirectory() as folder:
        for run in runs:
            write_run(run.frame, Path(folder) / f"{run.name}.csv")
        told = ask(Path(folder), without)
    answer = told["answer"]
    named = [
        f"{e['name']}:{e['channel']}" if "channel" in e else e["name"] for e in answer["effects"]
    ]
    truth = f"{name}:{effects[0].channel}" if effects[0].channel else name
    return {
        "hidden": truth,
        "size": HIDDEN[name],
        "without": list(without),
        "verdict": answer["verdict"],
        "named": named,
        "one_of": answer["one_of_keys"],
        "larger_than_usual": [e["larger_than_usual"] for e in answer["effects"]],
        "right": named == [truth] if not without else not named,
        "gap": answer["gap"]["holdout"],
        "remaining": {k: answer["remaining"][k] for k in ("before", "squared_tolerances")},
        "share_explained": answer["evidence"]["share_explained"],
        "runners_up": answer["runners_up"][:3],
        "data_faults": answer["data_faults"],
        "seconds": told["seconds"],
    }


def line_of(one: dict[str, Any]) -> str:
    """Return an answer as one line."""
    gap = one["gap"]
    what = f"{one['hidden']}{' (deleted)' if one['without'] else ''}"
    said = " + ".join(one["named"]) or one["verdict"]
    mark = "" if one["right"] else "  (not right)"
    return f"{what:<36}{said:<44}{gap['before']:8.2f} -> {gap['after']:6.2f}{mark}"


def main(arguments: list[str] | None = None) -> int:
    """Ask about every effect, with and without it in the catalogue."""
    parser = argparse.ArgumentParser(prog="benchmarks.gap.beyond", description=__doc__)
    parser.add_argument("--split", choices=SPLITS, required=True)
    parser.add_argument("--out", type=Path, required=True, metavar="DIR")
    parser.add_argument("--effects", nargs="+", default=list(HIDDEN), choices=HIDDEN)
    parser.add_argument("--deleted", action="store_true", help="ask again without each effect")
    args = parser.parse_args(arguments)
    answers = []
    for name in args.effects:
        seed = SPLITS[args.split] + FIRST + list(HIDDEN).index(name)
        for without in ((), (name,)) if args.deleted else ((),):
            answers.append(asked(name, seed, without))
            write_atomically(args.out / "beyond.json", json.dumps(answers, indent=1) + "\n")
            print(line_of(answers[-1]), flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
