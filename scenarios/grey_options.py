"""The options of the choice of temperatures, which more than one command has."""

from __future__ import annotations

import argparse
import json
from typing import Any

USUAL: dict[str, Any] = {
    "threshold": 0.9,
    "score": "correlation",
    "theta": 0.5,
    "image": "initial",
    "absolute_image": "as_read",
    "clusters": 4,
    "variables": None,
    "keep_quiet": False,
}
ALWAYS_TOLD = ("threshold", "score")
"""Stand in a file's provenance even where nobody asked for another."""


def add_grey_options(parser: argparse.ArgumentParser) -> None:
    """Declare them, and what else the choice of points goes by."""
    parser.add_argument(
        "--lambda",
        dest="threshold",
        type=float,
        default=USUAL["threshold"],
        metavar="LAMBDA",
        help="grey degree from which two temperatures form one group (default: 0.9)",
    )
    parser.add_argument(
        "--theta",
        type=float,
        default=USUAL["theta"],
        help="weight of the absolute in the comprehensive degree (default: 0.5)",
    )
    parser.add_argument(
        "--image",
        default=USUAL["image"],
        metavar="initial|mean|interval",
        help="dimensionless form for the relative degree (default: initial)",
    )
    parser.add_argument(
        "--absolute-image",
        default=USUAL["absolute_image"],
        metavar="as_read|initial|mean|interval",
        help="dimensionless form for the absolute degree (default: as_read, none; the jig-borer "
        "study has --absolute-image initial --image mean)",
    )
    parser.add_argument(
        "--clusters",
        type=int,
        default=USUAL["clusters"],
        help="groups of the hierarchical and fuzzy clustering (default: 4)",
    )
    parser.add_argument(
        "--variables",
        type=int,
        metavar="N",
        help="temperatures to choose: after one of each group the best of the rest (default: one "
        "of each group)",
    )
    parser.add_argument(
        "--keep-quiet",
        action="store_true",
        help="take temperatures that hardly move into account, too",
    )
    parser.add_argument(
        "--score",
        default=USUAL["score"],
        metavar="correlation|relational",
        help="what makes a temperature the best of its group (default: correlation)",
    )


def add_choice_options(parser: argparse.ArgumentParser) -> None:
    """Declare these options, and which target the choice goes by."""
    add_grey_options(parser)
    parser.add_argument(
        "--score-target",
        metavar="NAME",
        help="the one target to score against, as the studies do with elongation (default: the "
        "mean over all targets)",
    )


def grey_options(args: argparse.Namespace) -> dict[str, Any]:
    """Return the threshold, and what is not as usual, by the names that fit and survey give them.

    What a file's provenance holds is then what somebody has asked for.
    """
    given = {name: getattr(args, name) for name in USUAL}
    return {
        name: value for name, value in given.items() if name in ALWAYS_TOLD or value != USUAL[name]
    }


def choice_options(args: argparse.Namespace) -> dict[str, Any]:
    """Return what the choice of temperatures goes by, score and its target included."""
    target = {} if args.score_target is None else {"target": args.score_target}
    return grey_options(args) | target


def option_value(text: str) -> Any:
    """Return the value of an option: JSON, or the word that it is.

    Parameters
    ----------
    text : str
        What stands behind the equals sign.
    """
    try:
        return json.loads(text)
    except ValueError:
        return text
