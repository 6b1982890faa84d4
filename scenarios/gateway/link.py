"""One end of a bus: opened, kept, logged, and opened again when it is lost.

No thread and no polling: `receive` waits in the driver until a frame comes or the time is up.
"""

from __future__ import annotations

import contextlib
import time
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

import can

from measurement.errors import BadInput

FIRST_WAIT_S, LONGEST_WAIT_S = 0.5, 8.0
"""Back-off: the first wait before the bus is opened again, and the longest [s]."""
MOST_FAILURES = 12
"""So many frames in a row that cannot be sent mean that the bus is lost."""
ERR_BUS_OFF = 0x40
"""SocketCAN's class of error frames that says the controller has left the bus."""
LOGS = (".log", ".asc", ".blf")
Clock = Callable[[], float]


class Link:
    """A connection to a bus.

    Parameters
    ----------
    interface, channel : str
        As python-can names them: ``socketcan`` and ``vcan0``, ``virtual`` and any name.
    ids : iterable of int
        Identifiers to receive; where the driver can, the kernel drops all others.
    log : Path, optional
        Every frame sent and received goes there: candump (``.log``), ``.asc`` or ``.blf``.
    say : callable, optional
        Takes a line for people when the bus is lost or back.
    clock : callable, optional
        Monotonic time [s].
    options : dict, optional
        More settings of the interface, by python-can's names.

    Attributes
    ----------
    lost : str
        Empty while the bus is up; otherwise ``bus_off`` or ``interface_lost``.
    """

    def __init__(
        self,
        interface: str,
        channel: str,
        ids: Iterable[int],
        log: Path | None = None,
        say: Callable[[str], None] = lambda line: None,
        clock: Clock = time.monotonic,
        options: dict[str, Any] | None = None,
    ) -> None:
        self.interface, self.channel = interface, channel
        self._filters = [{"can_id": i, "can_mask": 0x7FF, "extended": False} for i in sorted(ids)]
        self._say, self._clock, self._options = say, clock, options or {}
        self._bus: can.BusABC | None = None
        self._wait_s, self._next_try = FIRST_WAIT_S, 0.0
        self._failures = 0
        self.lost = "interface_lost"
        self._writer = _writer(log) if log is not None else None

    @property
    def name(self) -> str:
        """What messages call this bus."""
        return f"{self.interface} {self.channel}"

    # Opening and closing

    def open(self, patience_s: float = 0.0) -> None:
        """Open the bus for the first time.

        Parameters
        ----------
        patience_s : float
            How long an interface may take to appear [s].

        Raises
        ------
        BadInput
            If there is no such interface or channel.
        """
        until = self._clock() + patience_s
        while True:
            try:
                self._connect()
                return
            except can.CanInterfaceNotImplementedError as error:
                raise BadInput("--interface", "", _line(error)) from None
            except (can.CanError, OSError, ValueError, TypeError, ImportError) as error:
                left = until - self._clock()
                if left <= 0.0:
                    raise BadInput(
                        f"{self.interface}:{self.channel}", "", f"cannot be opened: {_line(error)}"
                    ) from None
                time.sleep(min(FIRST_WAIT_S, left))

    def _connect(self) -> None:
        self._bus = can.Bus(
            interface=self.interface,
            channel=self.channel,
            can_filters=self._filters,
            **self._options,
        )
        self.lost, self._failures = "", 0

    def close(self) -> None:
        """Leave the bus and finish the log."""
        self._drop()
        if self._writer is not None:
            self._writer.stop()

    def _drop(self) -> None:
        bus, self._bus = self._bus, None
        if bus is not None:
            with contextlib.suppress(can.CanError, OSError, ValueError):
                bus.shutdown()

    def _lose(self, reason: str, text: str) -> None:
        if self.lost:
            return
        self._drop()
        self.lost, self._next_try = reason, self._clock() + self._wait_s
        self._say(
            f"{self.name}: {reason.replace('_', ' ')} ({text}); next try in {self._wait_s:g} s"
        )

    def _reopen(self) -> None:
        """Try once to open a bus that was lost; the wait before the next try doubles."""
        try:
            self._connect()
        except (can.CanError, OSError, ValueError) as error:
            self._drop()
            self._wait_s = min(2.0 * self._wait_s, LONGEST_WAIT_S)
            self._next_try = self._clock() + self._wait_s
            self._say(f"{self.name}: still lost ({_line(error)}); next try in {self._wait_s:g} s")
        else:
            self._say(f"{self.name}: back")

    def trust(self) -> None:
        """Note that the bus works: the next loss starts with the shortest wait again."""
        self._wait_s = FIRST_WAIT_S

    # Frames

    def receive(self, timeout_s: float) -> can.Message | None:
        """Wait for a frame, at most *timeout_s* [s]; None if none came or the bus is lost."""
        timeout_s = max(timeout_s, 0.0)
        if self._bus is None:
            pause = self._next_try - self._clock()
            time.sleep(min(max(pause, 0.0), timeout_s))
            if pause <= timeout_s:
                self._reopen()
            return None
        try:
            message = self._bus.recv(timeout_s)
        except (can.CanError, OSError, ValueError) as error:
            self._lose("interface_lost", _line(error))
            return None
        if message is None:
            return None
        self._record(message)
        if message.is_error_frame:
            if message.arbitration_id & ERR_BUS_OFF:
                self._lose("bus_off", "reported by the controller")
            return None
        if message.is_extended_id or message.is_remote_frame or message.is_fd:
            return None
        return message

    def send(self, messages: Iterable[can.Message]) -> bool:
        """Send frames; return whether all of them went out."""
        for message in messages:
            if self._bus is None:
                return False
            try:
                self._bus.send(message)
            except (can.CanError, OSError, ValueError) as error:
                self._failures += 1
                if self._failures >= MOST_FAILURES:
                    self._lose("interface_lost", _line(error))
                return False
            self._failures = 0
            if self._writer is not None:
                message.timestamp, message.is_rx = time.time(), False
                self._record(message)
        return True

    def _record(self, message: can.Message) -> None:
        if self._writer is not None:
            message.channel = self.channel
            self._writer.on_message_received(message)


def _writer(path: Path) -> Any:
    """Open a log of frames.

    Raises
    ------
    BadInput
        For an ending that names no format, or a file that cannot be written.
    """
    if path.suffix.lower() not in LOGS:
        raise BadInput(path, "", f"its ending must be one of {', '.join(LOGS)}")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        return can.Logger(str(path))
    except (OSError, ValueError) as error:
        raise BadInput(path, "", f"cannot be written: {_line(error)}") from None


def _line(error: Exception) -> str:
    return " ".join(str(error).split()) or type(error).__name__
