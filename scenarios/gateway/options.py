"""What the two commands of the bus have in common."""

from __future__ import annotations

import argparse
import contextlib
import math
import signal
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from types import FrameType

from measurement.errors import BadInput
from scenarios.gateway.database import COMPENSATOR, DBC, MACHINE, Database
from scenarios.gateway.link import Link
from scenarios.gateway.unit import options_of


def add_bus_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments that say which bus, and where files are."""
    parser.add_argument(
        "--interface", default="socketcan", help="a python-can interface (socketcan)"
    )
    parser.add_argument("--channel", default="vcan0", help="its channel (vcan0)")
    parser.add_argument(
        "--option",
        action="append",
        default=[],
        metavar="NAME=VALUE",
        help="another setting of the interface, such as bitrate=500000",
    )
    parser.add_argument("--dbc", type=Path, default=DBC, metavar="FILE", help="other frames")
    parser.add_argument(
        "--log", type=Path, metavar="FILE", help="log all frames: .log (candump), .asc or .blf"
    )
    parser.add_argument(
        "--state",
        type=Path,
        metavar="FILE",
        help="keep the FMU's state here, and go on from it when started again",
    )
    parser.add_argument(
        "--state-every", type=float, default=10.0, metavar="S", help="how often (10)"
    )
    parser.add_argument(
        "--timeout",
        type=float,
        metavar="MS",
        help="silence after which the other end is missing (what the DBC says)",
    )
    parser.add_argument(
        "--fmu-dir", type=Path, default=Path("dist"), metavar="DIR", help="where FMUs are (dist)"
    )
    parser.add_argument("--json", action="store_true", help="print a summary as JSON")
    parser.add_argument("--quiet", action="store_true", help="say nothing")


def check_bus_arguments(args: argparse.Namespace) -> None:
    """Refuse numbers that make no sense."""
    check_positive("--timeout", args.timeout)
    check_positive("--state-every", args.state_every)


def check_positive(name: str, value: float | None, *, zero: bool = False) -> None:
    """Refuse a number that is not above zero.

    Raises
    ------
    BadInput
        If it is not.
    """
    if value is None or (math.isfinite(value) and (value > 0.0 or (zero and value == 0.0))):
        return
    raise BadInput(name, "", f"{value:g} is not allowed: {'0 or more' if zero else 'above 0'}")


def new_link(
    args: argparse.Namespace, database: Database, other: str, say: Callable[[str], None]
) -> Link:
    """Return the link of a command line, not open yet, that hears the *other* node."""
    assert other in (MACHINE, COMPENSATOR)
    return Link(
        args.interface,
        args.channel,
        [frame.frame_id for frame in database.of(other)],
        args.log,
        say,
        options=options_of(args.option),
    )


def teller(name: str, args: argparse.Namespace) -> Callable[[str], None]:
    """Return what prints a line for people, with the time since now; silent when asked to be."""
    begun = time.monotonic()
    stream = sys.stderr

    def say(line: str) -> None:
        if not args.quiet:
            print(f"{name} {time.monotonic() - begun:7.1f} s  {line}", file=stream, flush=True)

    return say


@contextlib.contextmanager
def stop_flag() -> Iterator[Callable[[], bool]]:
    """Turn the first interrupt or termination into a question that the loops ask.

    A second one ends the program at once.
    """
    asked = False

    def stop(number: int, frame: FrameType | None) -> None:
        nonlocal asked
        if asked:
            raise KeyboardInterrupt
        asked = True

    kept = {number: signal.signal(number, stop) for number in (signal.SIGINT, signal.SIGTERM)}
    try:
        yield lambda: asked
    finally:
        for number, handler in kept.items():
            signal.signal(number, handler)
