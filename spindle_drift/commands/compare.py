"""``spindle-drift compare``: fit all error models to the same runs, judge them on unseen runs.

Give training runs and unseen runs (--train, --validate), or one set of runs that are left out in
turn (--runs). Splits are by run or by condition, never by row.
"""

from __future__ import annotations

import argparse
import json
from pathlib import Path
from typing import Any

from tqdm import tqdm

from fmu_compensator.fit.comparison import Comparison
from measurement.errors import BadInput
from measurement.faults import HANDLING, faults_text
from scenarios.arguments import add_json, add_parameters, add_results, parameters_of
from scenarios.assignments import options_of
from scenarios.grey_options import add_choice_options, choice_options
from scenarios.outputs import FOLDER
from scenarios.pages.comparison_page import ranking_text, write_comparison, write_figures
from scenarios.presets import add_as
from scenarios.results import write_findings
from spindle_drift.comparisons import compare

NAME = "compare"
HELP = "compare all error models on unseen runs"
READS = ("train", "validate", "runs", "machine")
WRITES = {"out": FOLDER}

INSTALLED = (
    "`fit` installs One Gaussian, wherever it ranks, unless --model names another: in few runs a "
    "lower error may be chance"
)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the command's arguments."""
    parser.add_argument("--train", nargs="+", type=Path, metavar="RUN", help="runs to learn from")
    parser.add_argument("--validate", nargs="+", type=Path, metavar="RUN", help="runs to judge on")
    parser.add_argument(
        "--runs", nargs="+", type=Path, metavar="RUN", help="instead: runs to leave out in turn"
    )
    add_parameters(
        parser,
        compare,
        "seed",
        by={"flag": "--split"},
        models={"nargs": None, "metavar": "NAME,NAME..."},
        points={"metavar": "grey|hierarchical|fuzzy|all|NAME,NAME..."},
        machine={"metavar": "FILE"},
    )
    add_choice_options(parser)
    parser.add_argument(
        "--option",
        action="append",
        default=[],
        metavar="MODEL.NAME=VALUE",
        help="option of one of the models, the value as JSON or a word; may be repeated",
    )
    add_json(parser, "print JSON instead of tables")
    add_results(parser, "write comparison.json, report.html and figures here")
    add_as(parser)


def run(args: argparse.Namespace) -> int:
    """Compare and print; nothing is written unless everything succeeds.

    Raises
    ------
    BadInput
        If the runs, models or options cannot be used.
    """
    if args.seed is not None and not 0 <= args.seed < 2**31:
        raise BadInput("compare", "seed", f"{args.seed} is not allowed: 0 to {2**31 - 1}")
    if args.runs and (args.train or args.validate):
        raise BadInput("compare", "--runs", "cannot stand beside --train and --validate")
    if not args.runs and not (args.train and args.validate):
        raise BadInput("compare", "", "--train and --validate are needed, or --runs")
    names = None if args.models is None else [name.strip() for name in args.models.split(",")]
    with tqdm(unit="fit", disable=None, leave=False) as bar:

        def tell(label: str, steps: int) -> None:
            bar.total = steps
            bar.set_description(label, refresh=False)
            bar.update()

        comparison = compare(
            args.runs or args.train,
            args.validate or (),
            models=names,
            **parameters_of(args, compare, "machine", "by", "seed", "study", "points"),
            grey=choice_options(args),
            options=_options(args),
            on_step=tell,
        )
    text = json.dumps(comparison.details, indent=1, allow_nan=False)
    lines = ["What is wrong with the data", faults_text(comparison.faults)]
    lines += [*(f"  {line}" for line in comparison.doubts), "", *_noted(comparison.results)]
    lines += ["", ranking_text(comparison.results), INSTALLED]
    if args.out is not None:
        written = write_findings(
            args.out,
            "comparison",
            text,
            lambda folder: [
                write_comparison(comparison.results, comparison.faults, folder / "report.html"),
                *write_figures(comparison.results, folder),
            ],
        )
        lines += ["", "wrote " + ", ".join(map(str, written))]
    print(text if args.json else "\n".join(lines))
    return 0


def _options(args: argparse.Namespace) -> dict[str, dict[str, Any]]:
    """Return the options of the models by name."""
    by_model: dict[str, dict[str, Any]] = {}
    form = "MODEL.NAME=VALUE"
    for name, value in options_of(args.option, form).items():
        model, dot, option = name.partition(".")
        if not dot:
            raise BadInput("--option", "", f"{name!r} is not of the form {form}")
        by_model.setdefault(model, {})[option] = value
    return by_model


def _noted(comparison: Comparison) -> list[str]:
    # Faulty data was printed above already.
    notes = [note for note in comparison.notes if not note.endswith(tuple(HANDLING.values()))]
    lines = ["What the models were given", *(f"  {note}" for note in notes)]
    lines += [f"  {name} is left out: {why}" for name, why in comparison.left_out.items()]
    return lines if len(lines) > 1 else [*lines, "  all rows of every run; no column was left out"]
