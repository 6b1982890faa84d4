"""The options of the choice of temperatures, shared by several commands."""

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
"""Options that a file's provenance records even at their defaults."""


def usual_choice() -> dict[str, Any]:
    """Return the defaults of the choice that a file's provenance always records."""
    usual = defaults(survey)
    return {name: usual[name] for name in ALWAYS_TOLD}


def add_grey_options(parser: argparse.ArgumentParser) -> None:
    """Declare the grey options, and the others of the choice of points."""
    add_parameters(parser, survey, **OPTIONS)


def add_choice_options(parser: argparse.ArgumentParser) -> None:
    """Declare these options, and the target of the choice."""
    add_grey_options(parser)
    text = "the one target to score against; growth: elongation, or what measures Z (default: all)"
    parser.add_argument("--score-target", dest="target", metavar="NAME", help=text)


def grey_options(args: argparse.Namespace) -> dict[str, Any]:
    """Return the threshold and options that differ from their defaults, by their names in fit.

    A file's provenance then holds only what was asked for.
    """
    usual = defaults(survey)
    return {
        name: value
        for name, value in parameters_of(args, survey, *OPTIONS).items()
        if name in ALWAYS_TOLD or value != usual[name]
    }


def choice_options(args: argparse.Namespace) -> dict[str, Any]:
    """Return the options of the choice of temperatures, including score and its target."""
    target = {} if args.target is None else {"target": args.target}
    return grey_options(args) | target
