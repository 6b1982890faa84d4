"""Drive a compensator with measured runs: drift before and after, run by run and overall."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from measurement.errors import BadInput, checked
from scenarios.arguments import add_json, add_parameters, add_results, add_runs, parameters_of, tell
from scenarios.assignments import quantity
from scenarios.outputs import FOLDER
from scenarios.probing import Probing
from scenarios.replay_runner import run_replay
from scenarios.scenario import Replay
from scenarios.table import as_text
from spindle_drift._options import add_fmu_folder

NAME = "replay"
HELP = "drive a compensator with measured runs"
READS = ("compensator", "runs", "machine")
WRITES = {"out": FOLDER}


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the command's arguments."""
    add_parameters(parser, run_replay, "compensator")
    add_runs(parser)
    add_results(parser, "results folder (default: results/replay)", default=Path("results/replay"))
    add_fmu_folder(parser)
    add_parameters(parser, run_replay, "tool_length_mm", "machine", "keep_frozen")
    # Values of these options carry their unit.
    add_parameters(
        parser,
        Probing,
        "seed",
        when_um={"flag": "--probe-when", "metavar": "LIMIT", "type": str},
        every_s={"flag": "--probe-every", "metavar": "TIME", "type": str},
        noise_um={"flag": "--probe-noise", "metavar": "NOISE", "type": str, "default": None},
    )
    add_json(parser, "print table.json instead of a table")
    parser.add_argument("--quiet", action="store_true", help="no progress bar, no table")


def run(args: argparse.Namespace) -> int:
    """Replay, write the folder, print the table."""
    checked(Replay, {"tool_length_mm": args.tool_length_mm}, "--tool-length")
    table, groups, notes = run_replay(
        args.compensator,
        args.runs,
        args.out,
        args.fmu_dir,
        near=Path(),
        **parameters_of(args, run_replay, "tool_length_mm", "machine", "keep_frozen"),
        probing=_probing(args),
        quiet=args.quiet or args.json,
    )
    where = f"results in {args.out}, report: {args.out / 'report.html'}"
    return tell(args, table, as_text(groups), *notes, where)


def _probing(args: argparse.Namespace) -> Probing | None:
    """Return the probe cycles that the options ask for, or None."""
    if not 0 <= args.seed < 2**31:
        raise BadInput("--seed", "", f"{args.seed} is not allowed: 0 to {2**31 - 1}")
    if args.when_um is None and args.every_s is None:
        if args.noise_um is not None:
            raise BadInput("--probe-noise", "", "needs --probe-when or --probe-every")
        return None
    given: dict[str, Any] = {
        name: quantity(option, text, unit, low, high)
        for name, option, text, unit, low, high in (
            ("every_s", "--probe-every", args.every_s, "s", 1.0, 1e7),
            ("when_um", "--probe-when", args.when_um, "um", 0.01, 1e5),
            ("noise_um", "--probe-noise", args.noise_um, "um", 0.0, 1000.0),
        )
        if text is not None
    }
    return Probing(**given, seed=args.seed)
