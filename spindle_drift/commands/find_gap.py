"""``spindle-drift find-gap``: find what is missing in a machine's model from measured runs."""

from __future__ import annotations

import argparse
import json
from pathlib import Path

from scenarios.arguments import add_json, add_parameters, add_results, parameters_of
from scenarios.outputs import FOLDER
from scenarios.progress import FIND_GAP, spoken
from spindle_drift.gaps import find_gap

NAME = "find-gap"
HELP = "find where a machine's model and measured runs disagree, and name what is missing"
READS = ("machine", "runs", "holdout")
WRITES = {"out": FOLDER}


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the command's arguments."""
    several = {"nargs": "+", "type": Path, "metavar": "RUN"}
    add_parameters(
        parser,
        find_gap,
        "machine",
        runs={"flag": "--runs", "required": True, **several},
        holdout={**several, "default": None},
    )
    add_results(parser, "folder for report and machine", required=True)
    add_parameters(
        parser,
        find_gap,
        "effects_only",
        "seed",
        "workers",
        without={"metavar": "EFFECT"},
        split_hours={"metavar": "H"},
        most={"metavar": "N"},
    )
    parser.add_argument(
        "--no-fmu", action="store_true", help="build no plant FMUs and co-simulate nothing"
    )
    add_json(parser, "print gap.json instead of five lines")
    parser.add_argument("--quiet", action="store_true", help="show no progress")


def run(args: argparse.Namespace) -> int:
    """Find the gap, write the folder, and print what was found."""
    with spoken(args.quiet, FIND_GAP) as say:
        gap = find_gap(
            **parameters_of(args, find_gap) | {"holdout": args.holdout or ()},
            fmu=not args.no_fmu,
            progress=say,
        )
    print(json.dumps(gap.table, indent=1) if args.json else gap.text)
    return 0
