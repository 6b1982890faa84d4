"""``spindle-drift fit``: fit a compensator file to measured or simulated runs."""

from __future__ import annotations

import argparse
import os
from inspect import signature
from typing import Any

from fmu_compensator.fit.fitting import fit_compensator
from measurement.errors import BadInput
from scenarios.arguments import (
    add_json,
    add_output,
    add_parameters,
    add_results,
    add_runs,
    parameters_of,
    tell,
)
from scenarios.assignments import options_of
from scenarios.fit_text import bar, report
from scenarios.grey_options import add_choice_options, choice_options
from scenarios.outputs import COMPENSATOR_FILE, FOLDER
from scenarios.presets import add_as
from spindle_drift.compensators import USUAL_MACHINE, fit

NAME = "fit"
HELP = "fit a compensator to runs and write its file"
READS = ("runs", "machine", "option")
WRITES = {"output": COMPENSATOR_FILE, "out": FOLDER}
RESERVED = frozenset(signature(fit_compensator).parameters)
"""Names that are arguments of the fit, not options of an error model."""
FIGURES_HELP = "draw what was found: ACF and PACF of a time series, convergence of a network"
NO_FIGURE = "figures are of time series (arma) and networks (bp, ga_bp)"
FITTED = (
    *("points", "input_form", "geometry_form", "tool_length_mm"),
    *("name", "title", "created", "use_speed", "jobs"),
)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the command's arguments."""
    add_runs(parser)
    add_parameters(parser, fit, "model", "machine")
    parser.add_argument(
        "--share", type=float, help="share of the predicted drift to send, 0 to 1 (default: 1)"
    )
    add_output(parser, "compensator file to write")
    parser.add_argument(
        "--option",
        action="append",
        default=[],
        metavar="NAME=VALUE",
        help="option of the error model, the value as JSON or a word; may be repeated "
        "(docs/methods.md names them)",
    )
    add_choice_options(parser)
    add_parameters(
        parser,
        fit_compensator,
        "name",
        "title",
        points={"metavar": "grey|hierarchical|fuzzy|all|NAME,NAME..."},
        input_form={"metavar": "rise|absolute|level"},
        geometry_form={"flag": "--form", "metavar": "rigid|pure_rotation"},
        tool_length_mm={"metavar": ("SHORTEST", "LONGEST")},
        created={"metavar": "YYYY-MM-DD"},
        use_speed={
            "flag": "--no-speed",
            "action": "store_false",
            "help": "do not use the spindle speed, which a control then need not send",
        },
        jobs={"metavar": "N", "default": os.cpu_count() or 1},
    )
    add_json(parser, "print the figures as JSON")
    add_results(parser, FIGURES_HELP)
    add_as(parser)


def run(args: argparse.Namespace) -> int:
    """Fit, write the file, and print how well it does."""
    if args.jobs < 1:
        raise BadInput("fit", "--jobs", f"{args.jobs} is not allowed: 1 or more")
    with bar() as on_step:
        compensator = fit(
            args.runs,
            args.model,
            machine=args.machine,
            study=args.study,
            on_step=on_step,
            grey=choice_options(args),
            limits={} if args.share is None else {"share": args.share},
            **parameters_of(args, fit_compensator, *FITTED),
            **_options(args.option),
        )
    path, table = compensator.save(args.output), compensator.model.table
    wrote = []
    if args.out is not None:
        from scenarios.pages.fit_figures import draw_fit  # only here: it loads Matplotlib

        drawn = draw_fit(table["provenance"]["figures"]["fit"], args.out)
        wrote = [f"wrote {name}" for name in drawn] or [f"nothing to draw: {NO_FIGURE}"]
    rig = table["provenance"]["rig"]
    if args.machine is None and rig["kind"] == "five_point":
        wrote.append(_assumed(rig))
    facts = {"file": str(path), "chosen": table["chosen"], **table["provenance"]}
    return tell(args, facts, *report(table, path), *wrote)


def _assumed(rig: dict[str, Any]) -> str:
    """Return the sensor positions assumed for a rig that nobody described; no figure shows them."""
    near, distal = (f"{rig[f'{pair}_x']}, {rig[f'{pair}_y']}" for pair in ("near", "distal"))
    return (
        f"no --machine says where the displacement sensors stand; taken, as at {USUAL_MACHINE}: "
        f"{near} {rig['near_to_gauge_mm']:g} mm outside the gauge line, {distal} "
        f"{rig['spacing_mm']:g} mm further out, {rig['axial']} towards "
        f"{'-' if rig['axial_sign'] > 0 else '+'}Z"
    )


def _options(given: list[str]) -> dict[str, Any]:
    """Return the options of the error model by name."""
    options = options_of(given)
    if taken := next(iter(options.keys() & RESERVED), None):
        problem = f"{taken} is not allowed: must be NAME=VALUE of the model"
        raise BadInput("fit", "--option", problem)
    return options
