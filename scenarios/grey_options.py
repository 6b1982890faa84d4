"""The options of the grey grouping, which more than one command has."""

from __future__ import annotations

import argparse
from typing import Any

USUAL: dict[str, Any] = {"theta": 0.5, "image": "initial", "absolute_image": "as_read"}


def add_grey_options(parser: argparse.ArgumentParser) -> None:
    """Declare them."""
    parser.add_argument(
        "--lambda",
        dest="threshold",
        type=float,
        default=0.9,
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


def grey_options(args: argparse.Namespace) -> dict[str, Any]:
    """Return the threshold, and what is not as usual, by the names that fit and survey give them.

    What a file's provenance holds is then what somebody has asked for.
    """
    given = {name: getattr(args, name) for name in USUAL}
    return {
        "threshold": args.threshold,
        **{name: value for name, value in given.items() if value != USUAL[name]},
    }
