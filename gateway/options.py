"""Options and helpers that both commands of the bus share."""

from __future__ import annotations

import argparse
import contextlib
import math
import signal
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

from gateway.background import Background
from gateway.database import COMPENSATOR, Database
from gateway.framelog import LARGEST_MB, FrameLog
from gateway.link import Link
from measurement.errors import BadInput
from measurement.stops import on_signals
from scenarios.assignments import options_of


def above_zero(text: str) -> float:
    """Return an option's number, which must be above zero."""
    return _number(text, "above 0", lambda value: value > 0.0)


def at_least_zero(text: str) -> float:
    """Return an option's number, which must not be negative."""
    return _number(text, "0 or more", lambda value: value >= 0.0)


ABOVE_ZERO: dict[str, Any] = {"type": above_zero}
AT_LEAST_ZERO: dict[str, Any] = {"type": at_least_zero}
"""Settings for an option made from a parameter that must not be negative."""


def _number(text: str, allowed: str, fits: Callable[[float], bool]) -> float:
    value = float(text)
    if not (math.isfinite(value) and fits(value)):
        raise argparse.ArgumentTypeError(f"{text} is not allowed: {allowed}")
    return value


def add_bus_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments for the bus and for files."""
    add = parser.add_argument
    add("--interface", default="socketcan", help="a python-can interface (socketcan)")
    add("--channel", default="vcan0", help="its channel (vcan0)")
    text = "another setting of the interface, such as bitrate=500000"
    add("--option", action="append", default=[], metavar="NAME=VALUE", help=text)
    add("--dbc", type=Path, metavar="FILE", help="a DBC file with other frames")
    text = (
        "a mapping file: frames of any form, as a control has them; or the name of one that ships"
    )
    add("--map", metavar="FILE", help=text)
    text = "log all frames: .log (candump), .asc or .blf"
    add("--log", type=Path, metavar="FILE", help=text)
    text = f"size at which a new log begins; nine older ones are kept ({LARGEST_MB:g})"
    add("--log-size", default=LARGEST_MB, metavar="MB", help=text, **ABOVE_ZERO)
    text = "keep the FMU's state here, and go on from it when started again"
    add("--state", type=Path, metavar="FILE", help=text)
    add("--state-every", default=10.0, metavar="S", help="how often (10)", **ABOVE_ZERO)
    text = (
        "silence after which the other end counts as missing, and oldest message that is used "
        "(what the DBC says)"
    )
    add("--timeout", metavar="MS", help=text, **ABOVE_ZERO)
    add("--fmu-dir", type=Path, default=Path("dist"), metavar="DIR", help="where FMUs are (dist)")
    text = (
        "any: the machine cannot prove that its cycles are fresh; answers are marked so (proven, "
        "where the frames carry a proof)"
    )
    add("--freshness", choices=("proven", "any"), default="proven", help=text)
    text = "make and check these proofs with the key of this file (AES-CMAC)"
    add("--key", type=Path, metavar="FILE", help=text)
    add("--json", action="store_true", help="print a summary as JSON")
    add("--quiet", action="store_true", help="say nothing")


def as_served(args: argparse.Namespace, database: Database) -> Database:
    """Return the frames for a machine that can, or cannot, prove that its cycles are fresh.

    Parameters
    ----------
    args : Namespace
        With the arguments of `add_bus_arguments`.
    database : Database
        All frames.

    Raises
    ------
    BadInput
        If there is a key, but no frame carries a proof.
    """
    if args.freshness == "any":
        database = database.unproven()
    if args.key is not None and database.proof is None:
        raise BadInput("--key", "", "has no meaning: no frame carries a proof of freshness")
    return database


def report(problems: list[BadInput]) -> int:
    """Print a line for each problem of a map; return the exit code.

    Parameters
    ----------
    problems : list of BadInput

    Returns
    -------
    int
        2 if there are any, else 0.
    """
    for problem in problems:
        print(f"spindle-drift: error: {problem}", file=sys.stderr)
    return 2 if problems else 0


@contextlib.contextmanager
def on_bus(
    name: str, args: argparse.Namespace, database: Database, other: str, patience_s: float
) -> Iterator[tuple[Callable[[str], None], Link, Callable[[], bool]]]:
    """Open the bus of a command line, to receive from the *other* node.

    Parameters
    ----------
    name : str
        The command's name, with which each line for people begins.
    args : Namespace
        With the arguments of `add_bus_arguments`.
    database : Database
        The frames.
    other : {"MACHINE", "COMPENSATOR"}
        The node at the other end.
    patience_s : float
        How long an interface may take to appear [s].

    Yields
    ------
    tuple
        A function that takes a line for people, the link, and a function that returns whether the
        program should end.
    """
    with teller(name, args) as say, contextlib.ExitStack() as stack:
        log = args.log and FrameLog(args.log, say, args.log_size)
        link = Link(
            args.interface,
            args.channel,
            # A gateway also listens for another gateway.
            [frame.key for frame in database.frames if frame.sender in (other, COMPENSATOR)],
            log,
            say,
            options=({"fd": True} if database.fd else {}) | options_of(args.option),
        )
        stack.callback(link.close)
        stopped = stack.enter_context(stop_flag(log.reopen if log else lambda: False))
        link.open(patience_s)
        yield say, link, stopped


@contextlib.contextmanager
def teller(name: str, args: argparse.Namespace) -> Iterator[Callable[[str], None]]:
    """Yield a function that prints a line with the time since now; silent with ``--quiet``.

    A thread prints, so that a terminal that hangs or is gone delays nothing.

    Parameters
    ----------
    name : str
        The command's name, with which each line begins.
    args : Namespace
        If its ``quiet`` is set, nothing is printed.

    Yields
    ------
    callable
        Takes a line; never waits and never fails.
    """
    begun, stream = time.monotonic(), sys.stderr
    printer = Background()

    def show(line: str) -> None:
        with contextlib.suppress(OSError, ValueError):
            print(line, file=stream, flush=True)

    def say(line: str) -> None:
        if not args.quiet:
            text = f"{name} {time.monotonic() - begun:7.1f} s  {line}"
            printer.do(lambda: show(text))

    try:
        yield say
    finally:
        printer.close()


@contextlib.contextmanager
def stop_flag(hung_up: Callable[[], bool] = lambda: False) -> Iterator[Callable[[], bool]]:
    """Turn the first interrupt or termination into a flag that the loops check.

    A second one ends the program at once.

    Parameters
    ----------
    hung_up : callable
        Called on a hangup (SIGHUP); returns whether it was handled. If not, a hangup counts as a
        termination.

    Yields
    ------
    callable
        Returns whether the program should end.
    """
    asked = False

    def stop(number: int, frame: object) -> None:
        nonlocal asked
        if number == getattr(signal, "SIGHUP", None) and hung_up():
            return
        if asked:
            raise KeyboardInterrupt
        asked = True

    with on_signals(("SIGINT", "SIGTERM", "SIGHUP", "SIGQUIT"), stop):
        yield lambda: asked
