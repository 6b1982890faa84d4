"""Replays a recorded log instead of the machine; its frames are sent unchanged."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Iterator
from importlib.util import find_spec
from math import inf, isnan
from pathlib import Path

import can

from gateway.codec import decode
from gateway.database import MACHINE, Database, Frame, key_of
from gateway.framelog import LOGS
from gateway.link import Link
from gateway.machine import AnswerReceiver
from measurement.errors import BadInput, one_line
from measurement.stops import LOOK_S

READ = (*LOGS, ".trc", ".mf4")


def recorded(path: Path, database: Database) -> list[can.Message]:
    """Return the machine's frames of a log, in order.

    Parameters
    ----------
    path : Path
        A log in a format that python-can reads.
    database : Database
        Defines which frames the machine sends.

    Raises
    ------
    BadInput
        If the log cannot be read or holds no such frame, or those of several channels.
    """
    if path.suffix.lower() not in READ:
        raise BadInput(path, "", f"its ending must be one of {', '.join(READ)}")
    if path.suffix.lower() == ".mf4" and find_spec("asammdf") is None:
        raise BadInput(path, "", "needs asammdf: pip install 'spindle-drift[mdf]'")
    if not path.is_file():
        raise BadInput(path, "", "no such file")
    ids = {frame.key for frame in database.frames if frame.sender == MACHINE}
    try:
        with can.LogReader(str(path)) as reader:
            messages = [
                message
                for message in reader
                if key_of(message) in ids and not message.is_error_frame
            ]
    except Exception as error:  # a damaged log makes the readers raise many kinds of errors
        raise BadInput(path, "", f"is not a log of frames: {one_line(error)[:200]}") from None
    if not messages:
        raise BadInput(path, "", "holds no frame of the machine")
    channels = sorted({str(message.channel) for message in messages})
    if len(channels) > 1:
        buses = ", ".join(channels)
        raise BadInput(path, "", f"holds frames of the machine on channels {buses}: keep one")
    return messages


def replay(
    messages: list[can.Message],
    database: Database,
    link: Link,
    answers: AnswerReceiver,
    *,
    speed_up: float | None = 1.0,
    wait_s: float = 10.0,
    stopped: Callable[[], bool] = lambda: False,
    clock: Callable[[], float],
) -> int:
    """Send recorded frames; return their number.

    Parameters
    ----------
    messages : list of can.Message
        From `recorded`.
    database : Database
        The frames.
    link : Link
        The bus, open.
    answers : AnswerReceiver
        Receives the gateway's answers.
    speed_up : float or None
        Speed relative to the recording; None: the next cycle as soon as the gateway has answered.
    wait_s : float
        How long a gateway may take to appear before the first frame [s].
    stopped : callable
        Returns whether to end early.
    clock : callable
        Monotonic time [s].

    Returns
    -------
    int
        Number of frames sent.
    """
    closing = database.closing(MACHINE)
    cycle_s = database.every_s or closing.cycle_s
    until = clock() + wait_s
    while answers.last is None and clock() < until and not stopped():
        answers.hear(link, min(clock() + cycle_s, until))
    sent = 0
    for message, due in _paced(messages, speed_up or inf, closing.timeout_s, clock()):
        while not stopped() and (left := due - clock()) > 0.0:
            time.sleep(min(left, LOOK_S))
        if stopped():
            break
        link.send([message])
        sent += 1
        if key_of(message) != closing.key or len(message.data) != closing.size:
            continue
        # Wait for the gateway's answer, or receive briefly so that its frames are taken in.
        patience_s, time_s = 0.0, None
        if speed_up is None:
            time_s = _running_time(closing, message)
            patience_s = cycle_s if time_s is None else answers.timeout_s
        answers.hear(link, clock() + patience_s, time_s)
    return sent


def _running_time(closing: Frame, message: can.Message) -> float | None:
    """Return the time of a cycle that the gateway answers [s]; None if the machine does not run."""
    if not closing.protection.intact(message.data):
        return None
    values = decode(closing, message.data).values
    running = values["machine_state"] == closing.signals["machine_state"].codes["running"]
    return values["machine_time"] if running and not isnan(values["machine_time"]) else None


def _paced(
    messages: Iterable[can.Message], speed_up: float, longest_s: float, due: float
) -> Iterator[tuple[can.Message, float]]:
    """Yield each frame of a log and when it is due [s], without pauses longer than *longest_s*."""
    before_s = inf
    for message in messages:
        gap_s = max(message.timestamp - before_s, 0.0)
        before_s = message.timestamp
        if gap_s <= longest_s:
            due += gap_s / speed_up
        yield message, due
