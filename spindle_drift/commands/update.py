"""``spindle-drift update``: add new runs to a compensator, without the old run files."""

from __future__ import annotations

import argparse
from pathlib import Path

from scenarios.arguments import add_json, add_output, add_parameters, add_runs, tell
from scenarios.fit_text import promise_line
from scenarios.outputs import COMPENSATOR_FILE
from spindle_drift.compensators import Compensator

NAME = "update"
HELP = "update a compensator with new runs, without the old files"
READS = ("compensator", "runs")
WRITES = {"output": COMPENSATOR_FILE}


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the command's arguments."""
    parser.add_argument(
        "compensator", type=Path, metavar="COMPENSATOR", help="compensator file (.json)"
    )
    add_runs(parser, "new run file (CSV)")
    add_output(parser, "compensator file to write; the old one stays")
    add_parameters(parser, Compensator.update, created={"metavar": "YYYY-MM-DD"})
    add_json(parser, "print the figures as JSON")


def run(args: argparse.Namespace) -> int:
    """Condition on the runs, write the file, and print the old compensator's remaining error."""
    before = Compensator.load(args.compensator)
    after = before.update(args.runs, created=args.created)
    path, provenance = after.save(args.output), after.model.provenance
    known = before.model.provenance
    new_runs = provenance["figures"]["updated"][len(known["figures"].get("updated", ())) :]
    facts = {"file": str(path), "new_runs": new_runs, "chosen": after.model.table["chosen"]}
    lines = [note for note in provenance["notes"] if note not in known["notes"]]
    lines += ["The old compensator in the new runs, RMSE [um] without it and with it:"]
    for run_left in new_runs:
        cells = [
            f"{axis} {left['no_model']:.1f} -> {left['model']:.1f}"
            for axis, left in run_left["axes"].items()
        ]
        lines.append(f"  {run_left['run']}: {', '.join(cells) or 'drift not measured'}")
    lines += filter(None, [promise_line(provenance["figures"]["unseen"])])
    lines.append(f"wrote {path}; it was learnt from {len(provenance['runs'])} runs")
    return tell(args, {**facts, **provenance}, *lines)
