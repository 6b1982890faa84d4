"""``spindle-drift find-gap``: what is missing in a machine's model, found in measured runs."""

from __future__ import annotations

import argparse
import json
from pathlib import Path

NAME = "find-gap"
HELP = "find where a machine's model and measured runs disagree, and name what is missing"


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
    parser.add_argument("--seed", type=int, default=0, help="of random starts and draws")
    parser.add_argument("--workers", type=int, help="processes (default: one for each core)")
    parser.add_argument("--json", action="store_true", help="print gap.json instead of five lines")
    parser.add_argument("--quiet", action="store_true", help="show no progress")


def run(args: argparse.Namespace) -> int:
    """Find the gap, write the folder, and say what was found."""
    from measurement.errors import BadInput
    from measurement.files import write_atomically
    from measurement.runs import read_run
    from plant_model.effects import catalogue
    from plant_model.gap.find import FEWEST_RUNS, find_gap
    from plant_model.gap.observations import observe
    from plant_model.gap.report import MACHINE_AFTER, Comparison, five_lines, report_of
    from plant_model.machine_file import machine_path, read_machine
    from plant_model.machine_writer import write_machine
    from scenarios.gap_page import PAGE, write_gap_page
    from scenarios.progress import spoken

    machine = read_machine(args.machine)
    for name in args.without:
        if name not in catalogue():
            raise BadInput("--without", "", f"{name} is not one of {', '.join(catalogue())}")
    if args.workers is not None and not 1 <= args.workers <= 256:
        raise BadInput("--workers", "", f"{args.workers} is outside 1..256")
    runs = [read_run(path) for path in args.runs]
    unseen = [read_run(path) for path in args.holdout or []]
    if not unseen:
        if len(runs) <= FEWEST_RUNS:
            raise BadInput(
                "--runs",
                "",
                f"{len(runs)} given; {FEWEST_RUNS + 1} or more are needed without --holdout",
            )
        unseen = [runs.pop()]
    names = [run.name for run in (*runs, *unseen)]
    twice = sorted({name for name in names if names.count(name) > 1})
    if twice:
        raise BadInput("--runs", "", f"{twice[0]} stands for more than one run")
    args.out.mkdir(parents=True, exist_ok=True)
    with spoken(args.quiet) as say:
        found = find_gap(
            machine,
            runs,
            without=args.without,
            seed=args.seed,
            workers=args.workers,
            progress=say,
        )
        say("judging by what was kept back")
        holdout = observe(machine, unseen)
        comparison = Comparison(found.before.machine, found.after.machine, holdout)
        table = report_of(found, comparison)
    write_machine(found.after.machine, args.machine, args.out / MACHINE_AFTER)
    facts = [
        ("Machine", f"{machine.title} ({machine_path(args.machine).name})"),
        ("Runs used", ", ".join(f"{run.name} ({run.sha256[:12]})" for run in runs)),
        ("Never used", ", ".join(f"{run.name} ({run.sha256[:12]})" for run in unseen)),
        ("Not considered", ", ".join(args.without) or "-"),
        ("Seed", str(args.seed)),
    ]
    write_gap_page(found, comparison, table, facts, args.out)
    text = json.dumps(table, indent=1) + "\n"
    write_atomically(args.out / "gap.json", text)
    print(text if args.json else "\n".join([*five_lines(table), f"report: {args.out / PAGE}"]))
    return 0
