"""Drive a compensator with measured runs: drift before and after, run by run and overall."""

from __future__ import annotations

import argparse
import re
from pathlib import Path
from typing import Any

from scenarios.arguments import add_json, add_parameters, add_results, add_runs, parameters_of, tell
from scenarios.outputs import FOLDER

NAME = "replay"
HELP = "drive a compensator with measured runs"
READS = ("compensator", "runs", "machine")
WRITES = {"out": FOLDER}
SECONDS = {"s": 1.0, "min": 60.0, "h": 3600.0}
LENGTHS = {"um": 1.0, "mm": 1000.0}


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the command's arguments."""
    from scenarios.probing import Probing
    from scenarios.replay_runner import run_replay
    from spindle_drift._options import add_fmu_folder

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
    from measurement.errors import checked
    from scenarios.replay_runner import run_replay
    from scenarios.scenario import Replay
    from scenarios.table import as_text

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


def _probing(args: argparse.Namespace) -> Any:
    """Return the probe cycles that the options ask for, or None."""
    from measurement.errors import BadInput
    from scenarios.probing import Probing

    if not 0 <= args.seed < 2**31:
        raise BadInput("--seed", "", f"{args.seed} is not allowed: 0 to {2**31 - 1}")
    noise = _quantity("--probe-noise", args.noise_um, LENGTHS, 0.0, 1000.0)
    if args.when_um is None and args.every_s is None:
        if noise is not None:
            raise BadInput("--probe-noise", "", "needs --probe-when or --probe-every")
        return None
    return Probing(
        every_s=_quantity("--probe-every", args.every_s, SECONDS, 1.0, 1e7),
        when_um=_quantity("--probe-when", args.when_um, LENGTHS, 0.01, 1e5),
        noise_um=Probing.noise_um if noise is None else noise,
        seed=args.seed,
    )


def _quantity(
    option: str, text: str | None, units: dict[str, float], low: float, high: float
) -> float | None:
    """Return an option's number with a unit, converted to the first of the units.

    Raises
    ------
    BadInput
        If it is no such number, or out of range.
    """
    from measurement.errors import BadInput, shown

    if text is None:
        return None
    found = re.fullmatch(r"\s*([0-9]*\.?[0-9]+(?:e[+-]?[0-9]+)?)\s*([a-z]+)\s*", text)
    value = float(found[1]) * units[found[2]] if found and found[2] in units else float("nan")
    if not low <= value <= high:
        unit = next(iter(units))
        allowed = f"a number with {' or '.join(units)}, {low:g} to {high:g} {unit}"
        raise BadInput(option, "", f"{shown(text)} is not allowed: {allowed}")
    return value
