"""``spindle-drift calibrate``: a machine's free parameters from measured runs."""

from __future__ import annotations

import argparse
import json
from dataclasses import asdict
from pathlib import Path

from scenarios.outputs import MACHINE_FILE, PAGE, check_output, marked

NAME = "calibrate"
HELP = "move a machine's free parameters so that it follows measured runs"
READS = ("machine", "runs")
WRITES = {"output": MACHINE_FILE}


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the command's arguments."""
    parser.add_argument("machine", metavar="MACHINE", help="machine file or shipped name")
    parser.add_argument("runs", nargs="+", type=Path, metavar="RUN", help="run file (CSV)")
    parser.add_argument(
        "-o", "--output", type=Path, required=True, metavar="FILE", help="machine file to write"
    )
    parser.add_argument("--starts", type=int, default=2, help="starting points (default: 2)")
    parser.add_argument("--seed", type=int, default=0, help="of the further starting points")
    parser.add_argument("--json", action="store_true", help="print JSON instead of a table")
    parser.add_argument("--quiet", action="store_true", help="show no progress")


def run(args: argparse.Namespace) -> int:
    """Calibrate, write the machine file, and say what the runs determine."""
    from gap_finder.advice import advice
    from gap_finder.regimes import by_channel, residuals
    from gap_finder.standing import calibrated
    from measurement.errors import BadInput
    from measurement.files import write_together
    from measurement.runs import read_run
    from plant_model.machine_file import read_machine
    from plant_model.machine_writer import machine_text
    from scenarios.calibration_page import calibration_page, page_beside
    from scenarios.gap_runner import begun_warm, not_compared, usable_runs
    from scenarios.parameter_rows import DETERMINED
    from scenarios.progress import CALIBRATE, spoken
    from scenarios.version import PROGRAM, version

    if not 1 <= args.starts <= 50:
        raise BadInput("--starts", "", f"{args.starts} is outside 1..50")
    page = page_beside(args.output)
    check_output(page, PAGE)
    machine = read_machine(args.machine)
    read = [read_run(path) for path in args.runs]
    runs, _, faults = usable_runs(machine, read)
    lacking = [*not_compared(machine, read), *begun_warm(read)]
    with spoken(args.quiet, CALIBRATE) as say:
        found, observed, more = calibrated(
            machine, runs, starts=args.starts, seed=args.seed, progress=say
        )
    faults += more
    path = args.output
    first, left = ([residuals(one, run) for run in observed] for one in (machine, found.machine))
    channels = {"before": by_channel(machine, first), "after": by_channel(found.machine, left)}
    told_by_it = advice(found.machine, left, found.parameters, first)
    facts = [
        ("machine", f"{args.machine} -> {path}"),
        *((run.name, f"SHA-256 {run.sha256}") for run in read),
        ("made by", f"{PROGRAM} {version()}"),
    ]
    text = calibration_page(
        machine,
        found,
        observed,
        told_by_it,
        [*(fault.text for fault in faults), *lacking],
        facts,
    )
    # Together: a page of another machine file would mislead.
    write_together({page: text, path: marked(machine_text(found.machine, args.machine))})
    if args.json:
        table = {
            "machine": str(path),
            "page": str(page),
            "channels": channels,
            "parameters": [asdict(entry) for entry in found.parameters],
            "data_faults": [asdict(fault) for fault in faults],
            "not_compared": lacking,
            "advice": [asdict(one) for one in told_by_it],
        }
        print(json.dumps(table, indent=1))
        return 0
    for fault in faults:
        print(f"{'put back' if fault.kind == 'probe_step' else 'left out'}: {fault.text}")
    print(*lacking, sep="\n", end="\n" if lacking else "")
    print(f"{'RMS [K, um]':<14}{'before':>10}{'after':>10}")
    for name, before in channels["before"].items():
        print(f"{name:<14}{before:>10.2f}{channels['after'][name]:>10.2f}")
    told = [one for one in found.parameters if one.prior_contraction >= DETERMINED or one.is_far]
    print(f"\nThe runs determine {len(told)} of {len(found.parameters)} free parameters:")
    for entry in sorted(told, key=lambda entry: -entry.prior_contraction):
        far = f"  {abs(entry.deviations):.1f} deviations: look at it" if entry.is_far else ""
        print(
            f"  {entry.name:<52}{entry.prior:>10.4g} -> {entry.value:.4g} "
            f"({entry.low:.4g} to {entry.high:.4g}) {entry.unit}{far}"
        )
    print("the others stay near the machine file's values")
    if told_by_it:
        print("\nWhat the machine file may lack ('spindle-drift find-gap' tries it):")
        print(*(f"  {one.text}" for one in told_by_it), sep="\n")
    print(f"wrote {path}, and {page} with the figures")
    return 0
