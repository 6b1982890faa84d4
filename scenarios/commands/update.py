"""``spindle-drift update``: new runs into a compensator, without the old files."""

from __future__ import annotations

import argparse
import json
from pathlib import Path

from fmu_compensator.fit.fitting import compensator_text
from fmu_compensator.fit.updating import update_compensator
from fmu_compensator.runtime.modelfile import load_model
from measurement.files import write_atomically
from measurement.runs import read_run
from scenarios.outputs import COMPENSATOR_FILE

NAME = "update"
HELP = "take new runs into a compensator, without the files of the old ones"
READS = ("compensator", "runs")
WRITES = {"output": COMPENSATOR_FILE}


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the command's arguments."""
    parser.add_argument(
        "compensator", type=Path, metavar="COMPENSATOR", help="compensator file (.json)"
    )
    parser.add_argument("runs", nargs="+", metavar="RUN", type=Path, help="new run file (CSV)")
    parser.add_argument(
        "-o",
        "--output",
        type=Path,
        required=True,
        metavar="FILE",
        help="compensator file to write; the old one stays",
    )
    parser.add_argument("--created", metavar="YYYY-MM-DD", help="date in the file (default: none)")
    parser.add_argument("--json", action="store_true", help="print the figures as JSON")


def run(args: argparse.Namespace) -> int:
    """Condition on the runs, write the file, and print what the old one left of them."""
    old = load_model(args.compensator)
    table, before = update_compensator(
        old, [read_run(path) for path in args.runs], created=args.created
    )
    path = write_atomically(args.output, compensator_text(table))
    if args.json:
        shown = {
            "file": str(path),
            "new_runs": table["provenance"]["figures"]["updated"][-len(before) :],
            "chosen": table["chosen"],
            **table["provenance"],
        }
        print(json.dumps(shown, indent=1))
        return 0
    print("The old compensator in the new runs, RMSE [um] without it and with it:")
    for one in before:
        cells = [f"{axis} {left.none:.1f} -> {left.left:.1f}" for axis, left in one.axes.items()]
        print(f"  {one.run}: {', '.join(cells) or 'drift not measured'}")
    print(f"wrote {path}; it was learnt from {len(table['provenance']['runs'])} runs")
    return 0
