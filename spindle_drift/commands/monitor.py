"""``spindle-drift monitor``: check whether a compensator still fits its machine."""

from __future__ import annotations

import argparse
import json
import math
from dataclasses import asdict
from functools import partial
from pathlib import Path

from tqdm import tqdm

from fmu_compensator.fit.installed import COVERAGE
from fmu_compensator.monitoring import Report
from fmu_compensator.monitoring.monitor import said_with
from measurement.files import json_ready
from scenarios.arguments import add_json, add_parameters, add_results, add_runs
from scenarios.outputs import FOLDER
from scenarios.results import write_findings
from spindle_drift.compensators import Compensator

NAME = "monitor"
HELP = "check from machine logs whether a compensator still fits"
READS = ("compensator", "runs", "machine")
WRITES = {"out": FOLDER}


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the command's arguments."""
    parser.add_argument(
        "compensator",
        type=Path,
        metavar="COMPENSATOR",
        help="compensator file (.json), or an FMU",
    )
    add_runs(parser, "log of a whole run (CSV); measured drift in all rows, in some, or in none")
    add_parameters(parser, Compensator.monitor, "machine")
    add_results(parser, "also write monitor.json and a figure here")
    add_json(parser)
    parser.add_argument("--quiet", action="store_true", help="no progress bar")


def run(args: argparse.Namespace) -> int:
    """Read the logs, and print the verdict first."""
    from scenarios.pages.monitor_figure import draw_monitor

    compensator = Compensator.load(args.compensator)
    with tqdm(total=len(args.runs), unit="run", disable=args.quiet or None, leave=False) as bar:
        report = compensator.monitor(
            args.runs, machine=args.machine, on_run=lambda run: bar.update()
        )
    text = json.dumps(json_ready(asdict(report), 6), indent=1, ensure_ascii=False, allow_nan=False)
    if args.out is not None:
        write_findings(args.out, "monitor", text, partial(draw_monitor, report))
    if args.json:
        print(text)
    else:
        print("\n".join(lines_of(report)))
        if args.out is not None:
            print(f"wrote monitor.json and monitor.png to {args.out}")
    return 0


def lines_of(report: Report) -> list[str]:
    """Return a report as text: the verdict, what to do, and a line for each run."""
    lines = [f"{report.verdict}: {report.summary}"]
    lines += [f"note: {note}" for note in report.notes]  # a wrong unit explains all that follows
    lines.append(f"what to do: {report.advice}")
    lines += [
        f"{gain.axis} moves {gain.value:.2f} times as far as predicted "
        f"({gain.low:.2f} to {gain.high:.2f}, {COVERAGE:.0%})"
        for gain in report.gains
    ]
    calm = report.verdict in ("fits", "unusual_runs")
    if calm and report.inside and not math.isnan(report.promised):
        held = ", ".join(f"{axis} {share:.0%}" for axis, share in report.inside.items())
        lines.append(f"inside the interval that promises {report.promised:.0%}: {held}")
    lines += ["", "run by run: RMSE [um] without -> with the compensator"]
    for run in report.runs:
        cells = [
            f"{e.axis} {e.none:.1f} -> {e.left:.1f}"
            + ("" if math.isnan(e.inside) else f" ({e.inside:.0%} inside)")
            for e in run.errors
        ]
        but = [f"{what} ({', '.join(axes)})" for what, axes in run.but.items()]
        verdict = said_with(run.verdict, run.verdict, but)
        lines.append(f"  {run.run}: {verdict}; {', '.join(cells) or 'drift not measured'}")
        lines += [f"    {reason}" for reason in run.reasons]
    return lines
