"""Drive a compensator with measured runs: drift before and after, run by run and overall."""

from __future__ import annotations

import argparse
import json
from pathlib import Path

from scenarios.outputs import FOLDER

NAME = "replay"
HELP = "drive a compensator with measured runs"
READS = ("compensator", "runs", "machine")
WRITES = {"out": FOLDER}
LONGEST_MM = 10_000.0


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the command's arguments."""
    parser.add_argument(
        "compensator", metavar="COMPENSATOR", help="an FMU, or a compensator file (.json)"
    )
    parser.add_argument("runs", nargs="+", type=Path, metavar="RUN", help="run file (CSV)")
    parser.add_argument(
        "--out", type=Path, default=Path("results/replay"), metavar="DIR", help="results folder"
    )
    parser.add_argument(
        "--fmu-dir", type=Path, default=Path("dist"), metavar="DIR", help="where FMUs are (dist)"
    )
    parser.add_argument(
        "--tool-length",
        type=float,
        metavar="MM",
        help="tool length at which a five-point rig's drift is taken (the FMU's start value)",
    )
    parser.add_argument(
        "--machine",
        help="machine whose five-point rig names the displacement sensors (S1 to S5, S5 along +Z)",
    )
    parser.add_argument(
        "--keep-frozen",
        action="store_true",
        help="count rows in which a displacement sensor was frozen or at the end of its range",
    )
    parser.add_argument("--json", action="store_true", help="print table.json instead of a table")
    parser.add_argument("--quiet", action="store_true", help="no progress bar, no table")


def run(args: argparse.Namespace) -> int:
    """Replay, write the folder, print the table."""
    from measurement.errors import BadInput
    from scenarios.replay_runner import run_replay
    from scenarios.table import as_text

    length = args.tool_length
    if length is not None and not -LONGEST_MM <= length <= LONGEST_MM:
        problem = f"{length:g} is not allowed: -{LONGEST_MM:g} to {LONGEST_MM:g} mm"
        raise BadInput("--tool-length", "", problem)
    table, groups, notes = run_replay(
        args.compensator,
        args.runs,
        args.out,
        args.fmu_dir,
        near=Path(),
        tool_length_mm=args.tool_length,
        machine=args.machine,
        keep_frozen=args.keep_frozen,
        quiet=args.quiet or args.json,
    )
    if args.json:
        print(json.dumps(table, indent=1, ensure_ascii=False))
    elif not args.quiet:
        print(as_text(groups), *notes, sep="\n")
        print(f"results in {args.out}, report: {args.out / 'report.html'}")
    return 0
