"""Drive a compensator with measured runs: drift before and after, run by run and overall."""

from __future__ import annotations

import argparse
import json
import re
from pathlib import Path
from typing import Any

from scenarios.arguments import add_json, add_results, add_runs
from scenarios.outputs import FOLDER
from scenarios.scenario_options import add_fmu_folder

NAME = "replay"
HELP = "drive a compensator with measured runs"
READS = ("compensator", "runs", "machine")
WRITES = {"out": FOLDER}
LONGEST_MM = 10_000.0
SECONDS = {"s": 1.0, "min": 60.0, "h": 3600.0}
LENGTHS = {"um": 1.0, "mm": 1000.0}


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the command's arguments."""
    parser.add_argument(
        "compensator", metavar="COMPENSATOR", help="an FMU, or a compensator file (.json)"
    )
    add_runs(parser)
    add_results(parser, "results folder", default=Path("results/replay"))
    add_fmu_folder(parser)
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
    parser.add_argument(
        "--probe-when",
        metavar="LIMIT",
        help="probe when the uncertainty of a measured axis passes this, such as 3um: the run's "
        "own drift then goes in through the measured inputs",
    )
    parser.add_argument(
        "--probe-every", metavar="TIME", help="probe at fixed intervals, such as 60min"
    )
    parser.add_argument(
        "--probe-noise",
        metavar="NOISE",
        help="standard deviation of a probe (0.5um); --seed gives it anew",
    )
    parser.add_argument("--seed", type=int, default=1, help="of the probes' noise (1)")
    add_json(parser, "print table.json instead of a table")
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
        probing=_probing(args),
        quiet=args.quiet or args.json,
    )
    if args.json:
        print(json.dumps(table, indent=1, ensure_ascii=False))
    elif not args.quiet:
        print(as_text(groups), *notes, sep="\n")
        print(f"results in {args.out}, report: {args.out / 'report.html'}")
    return 0


def _probing(args: argparse.Namespace) -> Any:
    """Return the probe cycles that the options ask for; None for none."""
    from measurement.errors import BadInput
    from scenarios.probing import NOISE_UM, Probing

    if not 0 <= args.seed < 2**31:
        raise BadInput("--seed", "", f"{args.seed} is not allowed: 0 to {2**31 - 1}")
    noise = _quantity("--probe-noise", args.probe_noise, LENGTHS, 0.0, 1000.0)
    if args.probe_when is None and args.probe_every is None:
        if noise is not None:
            raise BadInput("--probe-noise", "", "needs --probe-when or --probe-every")
        return None
    return Probing(
        every_s=_quantity("--probe-every", args.probe_every, SECONDS, 1.0, 1e7),
        when_um=_quantity("--probe-when", args.probe_when, LENGTHS, 0.01, 1e5),
        noise_um=NOISE_UM if noise is None else noise,
        seed=args.seed,
    )


def _quantity(
    option: str, text: str | None, units: dict[str, float], low: float, high: float
) -> float | None:
    """Return a number with a unit as an option gives it, in the first of the units.

    Raises
    ------
    BadInput
        If it is none, or out of range.
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
