"""``spindle-drift fit``: a compensator file from measured or simulated runs."""

from __future__ import annotations

import argparse
import json
from inspect import signature
from pathlib import Path
from typing import Any

from fmu_compensator.fit.fitting import fit_compensator
from measurement.errors import BadInput, shown
from scenarios.fit_figures import draw_series
from scenarios.fit_text import add_jobs, bar, check_jobs, report
from scenarios.grey_options import add_choice_options, choice_options, option_value
from scenarios.outputs import COMPENSATOR_FILE, FOLDER
from scenarios.presets import add_as
from spindle_drift.compensators import USUAL_MACHINE, fit

NAME = "fit"
HELP = "fit a compensator to runs and write its file"
READS = ("runs", "machine", "option")
WRITES = {"output": COMPENSATOR_FILE, "out": FOLDER}
RESERVED = frozenset(signature(fit_compensator).parameters)
"""Names that are arguments of the fit, not options of an error model."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the command's arguments."""
    parser.add_argument("runs", nargs="+", metavar="RUN", type=Path, help="run file (CSV)")
    parser.add_argument(
        "--model",
        help="error model, the mean function of the Gaussian (default: gaussian, no mean function)",
    )
    parser.add_argument(
        "--share",
        type=float,
        help="share of the predicted drift to send, 0 to 1 (default: 1)",
    )
    parser.add_argument(
        "-o",
        "--output",
        type=Path,
        required=True,
        metavar="FILE",
        help="compensator file to write",
    )
    parser.add_argument(
        "--machine",
        help="machine file, or name of a shipped machine, that says which sensors the runs hold; "
        f"without it the five-point rig of {USUAL_MACHINE} is taken where the runs have its "
        "columns, else displacement columns tell their axis by their name",
    )
    parser.add_argument(
        "--option",
        action="append",
        default=[],
        metavar="NAME=VALUE",
        help="option of the error model, the value as JSON or a word; may be repeated "
        "(docs/methods.md names them)",
    )
    parser.add_argument(
        "--points",
        metavar="grey|hierarchical|fuzzy|all|NAME,NAME...",
        help="temperatures to use: one per group of a clustering, every one, or those named "
        "(default: what is usual for the model)",
    )
    add_choice_options(parser)
    parser.add_argument(
        "--input-form",
        metavar="rise|absolute|level",
        help="temperatures relative to their first valid reading; as read; or as read while the "
        "drift counts from the start (default: what is usual for the model)",
    )
    parser.add_argument(
        "--form",
        default="rigid",
        metavar="rigid|pure_rotation",
        help="how a five-point rig's tilt moves the tool tip (default: rigid)",
    )
    parser.add_argument(
        "--tool-length",
        type=float,
        nargs=2,
        metavar=("SHORTEST", "LONGEST"),
        help="tools that the compensator may be used with [mm]",
    )
    parser.add_argument("--name", help="name in the file")
    parser.add_argument("--title", help="title in the file")
    parser.add_argument("--created", metavar="YYYY-MM-DD", help="date in the file (default: none)")
    add_jobs(parser)
    parser.add_argument("--json", action="store_true", help="print the figures as JSON")
    parser.add_argument(
        "--out",
        type=Path,
        metavar="DIR",
        help="write figures of what was found: ACF and PACF of a time series",
    )
    add_as(parser)


def run(args: argparse.Namespace) -> int:
    """Fit, write the file, and print how well it does."""
    check_jobs("fit", args.jobs)
    with bar() as on_step:
        compensator = fit(
            args.runs,
            args.model,
            machine=args.machine,
            study=args.study,
            on_step=on_step,
            jobs=args.jobs,
            points=args.points,
            input_form=args.input_form,
            grey=choice_options(args),
            geometry_form=args.form,
            tool_length_mm=None if args.tool_length is None else tuple(args.tool_length),
            limits={} if args.share is None else {"share": args.share},
            name=args.name,
            title=args.title,
            created=args.created,
            **_options(args.option),
        )
    path, table = compensator.save(args.output), compensator.model.table
    drawn = draw_series(table["provenance"]["figures"]["fit"], args.out)
    if args.json:
        facts = {"file": str(path), "chosen": table["chosen"], **table["provenance"]}
        print(json.dumps(facts, indent=1))
    else:
        print("\n".join([*report(table, path), *(f"wrote {name}" for name in drawn)]))
    return 0


def _options(given: list[str]) -> dict[str, Any]:
    """Return the options of the error model by name."""
    options = {}
    for text in given:
        name, equals, value = text.partition("=")
        if not equals or not name.isidentifier() or name in RESERVED:
            raise BadInput("fit", "--option", f"{shown(text)} is not allowed: must be NAME=VALUE")
        options[name] = option_value(value)
    return options
