"""Simulate a scenario many times: over a grid of values, and over random draws and noise."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from scenarios.arguments import add_json, add_parameters, add_results, tell
from scenarios.assignments import assignment
from scenarios.outputs import FOLDER_THAT_GOES_ON
from scenarios.scenario import read_scenario
from scenarios.sweep.plan import Request
from scenarios.sweep.runner import run_sweep
from scenarios.sweep.store import CASES
from scenarios.sweep.tables import as_text
from scenarios.version import PROGRAM
from spindle_drift._options import SETTINGS, add_fmu_folder

NAME = "sweep"
HELP = "simulate many variants of a scenario, on a grid or drawn at random"
READS = ("scenario", "overrides")
WRITES = {"out": FOLDER_THAT_GOES_ON}


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the command's arguments."""
    add_parameters(
        parser,
        Request,
        "scenario",
        "seed",
        vary={"flag": "--vary", "metavar": "NAME=VALUES"},
        repeat={"metavar": "N"},
        variants={"flag": "--variant", "metavar": "NAME"},
        overrides=SETTINGS,
    )
    add_results(parser, "folder (default: results/sweep_SCENARIO)")
    add_fmu_folder(parser)
    where = parser.add_mutually_exclusive_group()
    changes = {"workers": {"metavar": "N"}, "cluster": {"metavar": "ADDRESS"}}
    add_parameters(where, run_sweep, **changes)
    add_json(parser, "print summary.json")
    parser.add_argument("--quiet", action="store_true", help="no progress bar, no table")


def run(args: argparse.Namespace) -> int:
    """Run the missing cases of the sweep, write its folder, print the summary."""
    request = Request(
        args.scenario,
        tuple(args.vary),
        args.repeat,
        args.seed,
        tuple(args.variants),
        tuple(assignment(text) for text in args.overrides),
    )
    out = args.out
    if out is None:
        name = read_scenario(args.scenario, request.overrides).settings.name
        out = Path("results") / f"sweep_{name}"
    try:
        done = run_sweep(
            request,
            out,
            args.fmu_dir,
            workers=args.workers,
            cluster=args.cluster,
            quiet=args.quiet or args.json,
        )
    except KeyboardInterrupt:
        begun = next((out / CASES).glob("*.json"), None) is not None
        then = f"the same command goes on from {out}" if begun else "no case has ended yet"
        print(f"{PROGRAM}: interrupted; {then}", file=sys.stderr)
        return 130
    where = f"results in {out}: {', '.join(done['files'])}"
    tell(args, done, f"{done['title']}: {done['cases']} cases", "", as_text(done), "", where)
    if done["failed"]:
        count = f"{done['failed']} of {done['cases']} cases failed"
        print(f"{PROGRAM}: error: {count}: {done['problems'][0]}", file=sys.stderr)
        return 1
    return 0
