"""``spindle-drift calibrate``: calibrate a machine's free parameters to measured runs."""

from __future__ import annotations

import argparse
import json
from dataclasses import asdict

from measurement.files import write_together
from plant_model.machine_writer import machine_text
from scenarios.arguments import add_json, add_output, add_parameters, add_runs
from scenarios.outputs import MACHINE_FILE, PAGE, check_output, marked
from scenarios.pages.calibration_page import calibration_page, page_beside
from scenarios.progress import CALIBRATE, spoken
from scenarios.version import PROGRAM, version
from spindle_drift._inputs import as_runs
from spindle_drift.machines import Machine, calibrate

NAME = "calibrate"
HELP = "calibrate a machine's free parameters to measured runs"
READS = ("machine", "runs")
WRITES = {"output": MACHINE_FILE}


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the command's arguments."""
    add_parameters(parser, calibrate, "machine")
    add_runs(parser)
    add_output(parser, "machine file to write")
    add_parameters(parser, calibrate, "starts", "seed")
    add_json(parser, "print JSON instead of a table")
    parser.add_argument("--quiet", action="store_true", help="show no progress")


def run(args: argparse.Namespace) -> int:
    """Calibrate, write the machine file, and print how well the runs determine each parameter."""
    path, page = args.output, page_beside(args.output)
    check_output(page, PAGE)
    machine, runs = Machine(args.machine), as_runs(args.runs)
    with spoken(args.quiet, CALIBRATE) as say:
        result = calibrate(machine, runs, starts=args.starts, seed=args.seed, progress=say)
    parameters, lacking = result.found.parameters, result.left_out[len(result.faults) :]
    facts = [
        ("machine", f"{args.machine} -> {path}"),
        *((run.name, f"SHA-256 {run.sha256}") for run in runs),
        ("made by", f"{PROGRAM} {version()}"),
    ]
    text = calibration_page(
        machine.model, result.found, result.observed, result.advice, result.left_out, facts
    )
    # Together, because a page that shows another machine file would mislead.
    write_together({page: text, path: marked(machine_text(result.machine.model, args.machine))})
    if args.json:
        table = {
            "machine": str(path),
            "page": str(page),
            "channels": result.residuals.to_dict(),
            "parameters": [asdict(entry) for entry in parameters],
            "data_faults": [asdict(fault) for fault in result.faults],
            "remarks": lacking,
            "advice": [asdict(entry) for entry in result.advice],
        }
        print(json.dumps(table, indent=1))
        return 0
    for fault in result.faults:
        print(f"{'put back' if fault.kind == 'probe_step' else 'left out'}: {fault.text}")
    print(*lacking, sep="\n", end="\n" if lacking else "")
    print(f"{'RMS [K, um]':<14}{'before':>10}{'after':>10}")
    for name, before, after in result.residuals.itertuples():
        print(f"{name:<14}{before:>10.2f}{after:>10.2f}")
    determined = [entry for entry in parameters if entry.is_determined]
    print(f"\nThe runs determine {len(determined)} of {len(parameters)} free parameters:")
    for entry in sorted(determined, key=lambda entry: -entry.prior_contraction):
        far = f"  {abs(entry.deviations):.1f} deviations: look at it" if entry.is_far else ""
        print(
            f"  {entry.name:<52}{entry.prior:>10.4g} -> {entry.value:.4g} "
            f"({entry.low:.4g} to {entry.high:.4g}) {entry.unit}{far}"
        )
    print("the others stay near the machine file's values")
    if result.advice:
        print("\nWhat the machine file may lack ('spindle-drift find-gap' tries it):")
        print(*(f"  {entry.text}" for entry in result.advice), sep="\n")
    print(f"wrote {path}, and {page} with the figures")
    return 0
