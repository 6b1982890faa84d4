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

from gateway.background import Background
from gateway.database import COMPENSATOR, DBC, MACHINE, Database, read_database
from gateway.framelog import LARGEST_MB, FrameLog
from gateway.link import Link
from gateway.mapping import Mapping
from gateway.protocols.frames import mapping_named
from gateway.unit import options_of
from measurement.errors import BadInput

ROOM = 1000
"""Most lines for people that may wait to be printed."""


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
    parser.add_argument("--dbc", type=Path, metavar="FILE", help="a DBC file with other frames")
    parser.add_argument(
        "--map",
        metavar="FILE",
        help="a mapping file: frames of any form, as a control has them; or the name of one that "
        "ships",
    )
    parser.add_argument(
        "--log", type=Path, metavar="FILE", help="log all frames: .log (candump), .asc or .blf"
    )
    parser.add_argument(
        "--log-size",
        type=float,
        default=LARGEST_MB,
        metavar="MB",
        help=f"size at which a new log begins; nine older ones are kept ({LARGEST_MB:g})",
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
        help="silence after which the other end counts as missing, and oldest message that is used "
        "(what the DBC says)",
    )
    parser.add_argument(
        "--fmu-dir", type=Path, default=Path("dist"), metavar="DIR", help="where FMUs are (dist)"
    )
    parser.add_argument(
        "--freshness",
        choices=("proven", "any"),
        default="proven",
        help="any: the machine cannot prove that its cycles are fresh; answers are marked so "
        "(proven, where the frames carry a proof)",
    )
    parser.add_argument(
        "--key",
        type=Path,
        metavar="FILE",
        help="make and check these proofs with the key of this file (AES-CMAC)",
    )
    parser.add_argument("--json", action="store_true", help="print a summary as JSON")
    parser.add_argument("--quiet", action="store_true", help="say nothing")


def check_bus_arguments(args: argparse.Namespace) -> None:
    """Refuse settings that are not above zero."""
    check_positive("--timeout", args.timeout)
    check_positive("--state-every", args.state_every)
    check_positive("--log-size", args.log_size)


def read_frames(args: argparse.Namespace) -> tuple[Database, Mapping | None]:
    """Return the frames of a command line, and the map that they come from, if any.

    Returns
    -------
    database : Database
    mapping : Mapping or None
        None unless ``--map`` was given.

    Raises
    ------
    BadInput
        If the DBC file or the map cannot be read.
    """
    mapping = mapping_named(args.map, args.dbc)
    database = read_database(args.dbc or DBC) if mapping is None else mapping.database
    return served(args, database), mapping


def served(args: argparse.Namespace, database: Database) -> Database:
    """Return the frames as a machine serves them that can, or cannot, prove its cycles fresh.

    Parameters
    ----------
    args : Namespace
        With what `add_bus_arguments` declares.
    database : Database
        All frames.

    Raises
    ------
    BadInput
        If there is a key for a proof that no frame carries.
    """
    if args.freshness == "any":
        database = database.unproven()
    if args.key is not None and database.proof is None:
        raise BadInput("--key", "", "has no meaning: no frame carries a proof of freshness")
    return database


def told(problems: list[BadInput]) -> int:
    """Print a line for each problem of a map, and return the exit code.

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


def check_positive(name: str, value: float | None, *, zero: bool = False) -> None:
    """Refuse a number that is not above zero.

    Parameters
    ----------
    name : str
        Of the option, for the refusal.
    value : float or None
        None, an option that was not given, is allowed.
    zero : bool
        Whether 0 is allowed, too.

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
    """Return the link of a command line, not open yet, that hears the *other* node.

    Parameters
    ----------
    args : Namespace
        With what `add_bus_arguments` declares.
    database : Database
        The frames.
    other : {"machine", "compensator"}
        The node at the other end.
    say : callable
        Takes a line for people.
    """
    assert other in (MACHINE, COMPENSATOR)
    return Link(
        args.interface,
        args.channel,
        # A gateway also hears whether there is another one.
        [frame.key for frame in database.frames if frame.sender in (other, COMPENSATOR)],
        args.log and FrameLog(args.log, say, args.log_size),
        say,
        options=options_of(args.option),
    )


@contextlib.contextmanager
def teller(name: str, args: argparse.Namespace) -> Iterator[Callable[[str], None]]:
    """Give a function that prints a line with the time since now; silent with ``--quiet``.

    A thread prints, so that a terminal that hangs or is gone delays nothing.

    Parameters
    ----------
    name : str
        Of the command; each line begins with it.
    args : Namespace
        Its ``quiet`` says whether anything is printed.

    Yields
    ------
    callable
        Takes a line; never waits and never fails.
    """
    begun, stream = time.monotonic(), sys.stderr
    printer = Background(ROOM)

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
def on_signal(name: str, do: Callable[[], None]) -> Iterator[None]:
    """Call a function at a signal, where the system has it.

    Parameters
    ----------
    name : str
        Such as ``SIGUSR1``.
    do : callable
        Called in the main thread; short.

    Yields
    ------
    None
        While the signal is dealt with so.
    """
    number = getattr(signal, name, None)
    if number is None:
        yield
        return
    kept = signal.signal(number, lambda *_: do())
    try:
        yield
    finally:
        signal.signal(number, kept)


@contextlib.contextmanager
def stop_flag(hung_up: Callable[[], bool] = lambda: False) -> Iterator[Callable[[], bool]]:
    """Turn the first interrupt or termination into a flag that the loops check.

    A second one ends the program at once.

    Parameters
    ----------
    hung_up : callable
        Called at a hangup (SIGHUP); returns whether that was dealt with. Otherwise it is a
        termination like others.

    Yields
    ------
    callable
        Returns whether the program should end.
    """
    asked = False

    def stop(number: int, frame: FrameType | None) -> None:
        nonlocal asked
        if number == getattr(signal, "SIGHUP", None) and hung_up():
            return
        if asked:
            raise KeyboardInterrupt
        asked = True

    names = ("SIGINT", "SIGTERM", "SIGHUP", "SIGQUIT")
    numbers = [getattr(signal, name) for name in names if hasattr(signal, name)]
    kept = {number: signal.signal(number, stop) for number in numbers}
    try:
        yield lambda: asked
    finally:
        for number, handler in kept.items():
            signal.signal(number, handler)
