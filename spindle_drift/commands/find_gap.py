"""``spindle-drift find-gap``: what is missing in a machine's model, found in measured runs."""

from __future__ import annotations

import argparse
import json
from pathlib import Path

from scenarios.outputs import FOLDER

NAME = "find-gap"
HELP = "find where a machine's model and measured runs disagree, and name what is missing"
READS = ("machine", "runs", "holdout")
WRITES = {"out": FOLDER}


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the command's arguments."""
    parser.add_argument("machine", metavar="MACHINE", help="machine file or shipped name")
    parser.add_argument(
        "--runs", nargs="+", type=Path, required=True, metavar="RUN", help="runs to calibrate on"
    )
    parser.add_argument(
        "--holdout",
        nargs="+",
        type=Path,
        metavar="RUN",
        help="runs to judge by, used once at the end (default: the last of --runs is kept back)",
    )
    parser.add_argument(
        "--out", type=Path, required=True, metavar="DIR", help="folder for report and machine"
    )
    parser.add_argument(
        "--without", nargs="+", default=[], metavar="EFFECT", help="effects not to consider"
    )
    parser.add_argument(
        "--split-hours",
        type=float,
        metavar="H",
        help="cut --runs that are longer into pieces of H hours, each begun where the one before "
        "ended",
    )
    parser.add_argument(
        "--most", type=int, default=4, metavar="N", help="additions to make at most (default: 4)"
    )
    parser.add_argument(
        "--effects-only", action="store_true", help="add effects, and leave the description alone"
    )
    parser.add_argument("--seed", type=int, default=0, help="of random starts and draws")
    parser.add_argument("--workers", type=int, help="processes (default: one for each core)")
    parser.add_argument(
        "--no-fmu", action="store_true", help="build no plant FMUs and co-simulate nothing"
    )
    parser.add_argument("--json", action="store_true", help="print gap.json instead of five lines")
    parser.add_argument("--quiet", action="store_true", help="show no progress")


def run(args: argparse.Namespace) -> int:
    """Find the gap, write the folder, and say what was found."""
    from gap_finder.search import Search
    from scenarios.gap_runner import GapTask, run_find_gap
    from scenarios.progress import FIND_GAP, spoken

    asked = GapTask(
        args.machine,
        args.runs,
        args.holdout or [],
        args.out,
        Search(args.without, args.most, not args.effects_only, args.seed, args.workers),
        fmu=not args.no_fmu,
        split_hours=args.split_hours,
    )
    with spoken(args.quiet, FIND_GAP) as say:
        table, lines = run_find_gap(asked, say)
    print(json.dumps(table, indent=1) if args.json else "\n".join(lines))
    return 0
