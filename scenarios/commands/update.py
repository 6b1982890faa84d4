"""``spindle-drift update``: new runs into a compensator, without the old files."""

from __future__ import annotations

import argparse
import json
from pathlib import Path

from fmu_compensator.fit.choosing import CANDIDATES
from fmu_compensator.fit.fitting import compensator_text
from fmu_compensator.fit.updating import update_compensator
from fmu_compensator.monitoring import monitor
from fmu_compensator.monitoring.monitor import RunReport
from fmu_compensator.runtime.modelfile import load_model
from measurement.errors import BadInput
from measurement.files import write_atomically
from measurement.runs import read_run
from scenarios.fit_text import add_jobs, bar, check_jobs, kinds_of, report
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
    parser.add_argument(
        "--choose",
        action="store_true",
        help="choose the error model anew (default: its kind and options stay)",
    )
    parser.add_argument(
        "--among",
        metavar="NAME,NAME...",
        help=f"error models to choose among, with --choose (default: {','.join(CANDIDATES)})",
    )
    parser.add_argument("--created", metavar="YYYY-MM-DD", help="date in the file (default: none)")
    add_jobs(parser)
    parser.add_argument("--json", action="store_true", help="print the figures as JSON")


def run(args: argparse.Namespace) -> int:
    """Fit anew, write the file, and print what the old one did in the new runs."""
    check_jobs("update", args.jobs)
    if args.among is not None and not args.choose:
        raise BadInput("update", "--among", "needs --choose")
    old = load_model(args.compensator)
    runs = [read_run(path) for path in args.runs]
    with bar() as on_step:
        table = update_compensator(
            old,
            runs,
            choose=args.choose,
            candidates=kinds_of(args.among),
            created=args.created,
            jobs=args.jobs,
            on_step=on_step,
        )
    before = monitor(old, runs).runs
    path = write_atomically(args.output, compensator_text(table))
    if args.json:
        shown = {
            "file": str(path),
            "new_runs": [{"run": one.run, "left_um": _left(one)} for one in before],
            "chosen": table["chosen"],
            **table["provenance"],
        }
        print(json.dumps(shown, indent=1))
        return 0
    print("The old compensator in the new runs, RMSE [um] without it and with it:")
    for one in before:
        cells = [f"{e.axis} {e.none:.1f} -> {e.left:.1f}" for e in one.errors]
        print(f"  {one.run}: {', '.join(cells) or 'drift not measured'}")
    print("\nThe new one:")
    print("\n".join(report(table, path)))
    return 0


def _left(one: RunReport) -> dict[str, dict[str, float]]:
    return {e.axis: {"no_compensation": e.none, "old_compensator": e.left} for e in one.errors}
