"""Simulate a scenario many times: over a grid of values, and over random draws and noise."""

from __future__ import annotations

import argparse
import json
import sys
from pathlib import Path

from scenarios.outputs import FOLDER_THAT_GOES_ON
from scenarios.scenario_options import add_fmu_folder, add_settings

NAME = "sweep"
HELP = "simulate a scenario many times, with what varies on a grid or drawn at random"
READS = ("scenario", "set")
WRITES = {"out": FOLDER_THAT_GOES_ON}


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the command's arguments."""
    parser.add_argument("scenario", metavar="SCENARIO", help="a name from 'list', or a TOML file")
    parser.add_argument(
        "--vary",
        action="append",
        default=[],
        metavar="NAME=VALUES",
        help="an input, a parameter of the plant or a key of the scenario, and a,b,c or "
        "low..high:COUNT (a grid), low..high, low..high:log or mean+-sd (drawn for every repeat); "
        "an x before them multiplies what the scenario has",
    )
    parser.add_argument(
        "--repeat",
        type=int,
        default=1,
        metavar="N",
        help="runs of every point of the grid, each with its own draws and noise (1)",
    )
    parser.add_argument("--seed", type=int, help="of draws and noise (the scenario's)")
    parser.add_argument(
        "--variant",
        action="append",
        default=[],
        metavar="NAME",
        help="one of the scenario's variants (all)",
    )
    add_settings(parser)
    parser.add_argument("--out", type=Path, metavar="DIR", help="folder (results/sweep_<scenario>)")
    add_fmu_folder(parser)
    where = parser.add_mutually_exclusive_group()
    where.add_argument("--workers", type=int, metavar="N", help="processes (all cores)")
    where.add_argument(
        "--cluster", metavar="ADDRESS", help="of a Dask scheduler, for example tcp://host:8786"
    )
    parser.add_argument("--json", action="store_true", help="print summary.json")
    parser.add_argument("--quiet", action="store_true", help="no progress bar, no table")


def run(args: argparse.Namespace) -> int:
    """Run what is missing of the sweep, write its folder, print the summary."""
    from scenarios.assignments import assignment
    from scenarios.scenario import read_scenario
    from scenarios.sweep.plan import Request
    from scenarios.sweep.runner import run_sweep
    from scenarios.sweep.tables import as_text
    from scenarios.version import PROGRAM

    request = Request(
        args.scenario,
        tuple(args.vary),
        args.repeat,
        args.seed,
        tuple(args.variant),
        tuple(assignment(text) for text in args.set),
    )
    out = args.out
    if out is None:
        name = read_scenario(args.scenario, request.overrides).settings.name
        out = Path("results") / f"sweep_{name}"
    try:
        found = run_sweep(
            request,
            out,
            args.fmu_dir,
            workers=args.workers,
            cluster=args.cluster,
            quiet=args.quiet or args.json,
        )
    except KeyboardInterrupt:
        print(f"{PROGRAM}: interrupted; the same command goes on from {out}", file=sys.stderr)
        return 130
    if args.json:
        print(json.dumps(found, indent=1, ensure_ascii=False))
    elif not args.quiet:
        print(f"{found['title']}: {found['cases']} cases\n\n{as_text(found)}\n")
        print(f"results in {out}: {', '.join(found['files'])}")
    if found["failed"]:
        count = f"{found['failed']} of {found['cases']} cases failed"
        print(f"{PROGRAM}: error: {count}: {found['problems'][0]}", file=sys.stderr)
        return 1
    return 0
