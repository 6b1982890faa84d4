"""The options of the choice of temperatures, which more than one command has."""

from __future__ import annotations

import argparse
from typing import Any

from fmu_compensator.fit.survey import survey
from scenarios.arguments import add_parameters, defaults, parameters_of

FORMS = "initial|mean|interval"
OPTIONS: dict[str, dict[str, str]] = {
    "threshold": {"flag": "--lambda", "metavar": "LAMBDA"},
    "theta": {},
    "image": {"metavar": FORMS},
    "absolute_image": {"metavar": f"as_read|{FORMS}"},
    "clusters": {},
    "variables": {"metavar": "N"},
    "keep_quiet": {},
    "score": {"metavar": "correlation|relational"},
}
ALWAYS_TOLD = ("threshold", "score")
"""Stand in a file's provenance even where nobody asked for another."""


def usual_choice() -> dict[str, Any]:
    """Return what a file's provenance always says of the choice, where nothing else is asked."""
    usual = defaults(survey)
    return {name: usual[name] for name in ALWAYS_TOLD}


def add_grey_options(parser: argparse.ArgumentParser) -> None:
    """Declare them, and what else the choice of points goes by."""
    add_parameters(parser, survey, **OPTIONS)


def add_choice_options(parser: argparse.ArgumentParser) -> None:
    """Declare these options, and which target the choice goes by."""
    add_grey_options(parser)
    text = "the one target to score against; growth: elongation, or what measures Z (default: all)"
    parser.add_argument("--score-target", dest="target", metavar="NAME", help=text)


def grey_options(args: argparse.Namespace) -> dict[str, Any]:
    """Return the threshold, and what is not as usual, by the names that fit and survey give them.

    What a file's provenance holds is then what somebody has asked for.
    """
    usual = defaults(survey)
    return {
        name: value
        for name, value in parameters_of(args, survey, *OPTIONS).items()
        if name in ALWAYS_TOLD or value != usual[name]
    }


def choice_options(args: argparse.Namespace) -> dict[str, Any]:
    """Return what the choice of temperatures goes by, score and its target included."""
    target = {} if args.target is None else {"target": args.target}
    return grey_options(args) | target
