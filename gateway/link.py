"""A connection to a bus, with its log; it is reopened when it is lost.

It uses no thread and no polling: `receive` waits in the driver until a frame comes or the time is
up.
"""

from __future__ import annotations

import contextlib
import time
import uuid
from collections.abc import Callable, Iterable
from math import inf
from typing import Any

import can

from gateway.clocks import steady
from gateway.database import EXTENDED
from gateway.framelog import FrameLog
from gateway.timebase import CLOCK_DRIFT
from measurement.errors import BadInput, one_line

FIRST_WAIT_S, LONGEST_WAIT_S = 0.5, 8.0
"""Back-off: the first and the longest wait before the bus is opened again [s]; a bus that takes no
frame during the first is lost. Set on no data."""
ERR_BUS_OFF = 0x40
"""The class of error frames for a controller that has left the bus: given by SocketCAN."""
WALL_CLOCK = ("socketcan", "udp_multicast", "virtual")
"""Interfaces that stamp frames with this computer's time of day on arrival."""
ECHOING = ("udp_multicast",)
"""Interfaces on which a node hears its own frames; each frame carries the name of its channel."""
Clock = Callable[[], float]


class Link:
    """A connection to a bus.

    Parameters
    ----------
    interface, channel : str
        As python-can names them: ``socketcan`` and ``vcan0``, ``virtual`` and any name.
    ids : iterable of int
        Keys of the frames to receive; the kernel drops all others, if the driver supports it.
    log : FrameLog, optional
        Takes all frames sent and received.
    say : callable, optional
        Takes a line for people when the bus is lost or back.
    clock : callable, optional
        Monotonic time [s].
    options : dict, optional
        Further settings of the interface, by python-can's names.

    Attributes
    ----------
    lost : str
        Empty while the bus is up; otherwise ``bus_off`` or ``interface_lost``.
    waited_s : float
        How long the frame received last had waited in this computer [s].
    junk : int
        Number of arrivals that were no frame.
    """

    def __init__(
        self,
        interface: str,
        channel: str,
        ids: Iterable[int],
        log: FrameLog | None = None,
        say: Callable[[str], None] = lambda line: None,
        clock: Clock = steady,
        options: dict[str, Any] | None = None,
    ) -> None:
        self.interface, self.channel = interface, channel
        self._filters = [_filter(key) for key in sorted(ids)]
        self._extended = any(entry["extended"] for entry in self._filters)
        self._say, self._clock, self._options = say, clock, options or {}
        self._fd = bool(self._options.get("fd"))
        self._bus: can.BusABC | None = None
        self._wait_s, self._next_try = FIRST_WAIT_S, 0.0
        self._failing_since = inf
        self.lost = "interface_lost"
        self.waited_s, self.junk = 0.0, 0
        self._arrived_at = 0.0
        self._log = log
        self._mark = uuid.uuid4().hex  # as the channel of own frames, if they come back
        self._quickest_s, self._quickest_at = float("inf"), 0.0

    @property
    def name(self) -> str:
        """The bus as messages name it."""
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
                raise BadInput("--interface", "", one_line(error)) from None
            except (can.CanError, OSError, ValueError, TypeError, ImportError) as error:
                left = until - self._clock()
                if left <= 0.0:
                    raise BadInput(
                        f"{self.interface}:{self.channel}",
                        "",
                        f"cannot be opened: {one_line(error)}",
                    ) from None
                time.sleep(min(FIRST_WAIT_S, left))

    def _connect(self) -> None:
        self._bus = can.Bus(
            interface=self.interface,
            channel=self.channel,
            can_filters=self._filters,
            **self._options,
        )
        self.lost, self._failing_since = "", inf
        self._arrived_at = self._clock()

    def close(self) -> None:
        """Leave the bus and close the log."""
        self._drop()
        if self._log is not None:
            self._log.close()

    def _drop(self) -> None:
        bus, self._bus = self._bus, None
        if bus is not None:
            with contextlib.suppress(can.CanError, OSError, ValueError):
                bus.shutdown()

    def _lose(self, reason: str, text: str) -> None:
        if self.lost:
            return
        self._drop()
        self.lost = reason
        self._wait(f"{reason.replace('_', ' ')} ({text})")

    def _wait(self, what: str) -> None:
        """Report the problem and when the bus is reopened; the next wait is twice as long."""
        self._next_try = self._clock() + self._wait_s
        self._say(f"{self.name}: {what}; next try in {self._wait_s:g} s")
        self._wait_s = min(2.0 * self._wait_s, LONGEST_WAIT_S)

    def _reopen(self) -> None:
        """Try once to reopen a lost bus."""
        try:
            self._connect()
        except (can.CanError, OSError, ValueError) as error:
            self._drop()
            self._wait(f"still lost ({one_line(error)})")
        else:
            self._say(f"{self.name}: back")

    def trust(self) -> None:
        """Note that the bus works, so that the next loss starts with the shortest wait again."""
        self._wait_s = FIRST_WAIT_S

    # Frames

    def receive(self, timeout_s: float) -> can.Message | None:
        """Return the next frame within *timeout_s* [s]; None if none came or the bus is lost."""
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
            if _is_junk(error):
                self.junk += 1
            else:
                self._lose("interface_lost", one_line(error))
            return None
        if message is None or message.channel == self._mark:
            return None
        # Frames arrive one after the other, even while the time of day is set.
        now = self._clock()
        self.waited_s = min(self._age(message), now - self._arrived_at)
        self._arrived_at = now - self.waited_s
        self._record(message)
        if message.is_error_frame:
            if message.arbitration_id & ERR_BUS_OFF:
                self._lose("bus_off", "reported by the controller")
            return None
        if message.is_remote_frame or (message.is_fd and not self._fd):
            return None
        if message.is_extended_id and not self._extended:
            return None
        return message

    def send(self, messages: Iterable[can.Message]) -> bool:
        """Send frames; return whether all of them went out."""
        for message in messages:
            if self._bus is None:
                return False
            if self.interface in ECHOING:
                message.channel = self._mark
            try:
                self._bus.send(message)
            except (can.CanError, OSError, ValueError) as error:
                # A full queue may drain again.
                self._failing_since = min(self._failing_since, self._clock())
                if self._clock() - self._failing_since >= FIRST_WAIT_S:
                    self._lose("interface_lost", one_line(error))
                return False
            self._failing_since = inf
            if self._log is not None:
                message.timestamp, message.is_rx = time.time(), False
                self._record(message)
        return True

    def _age(self, message: can.Message) -> float:
        """Return how long ago a frame arrived, by its driver's timestamp [s]."""
        if not message.timestamp:
            return 0.0
        if self.interface in WALL_CLOCK:
            return max(time.time() - message.timestamp, 0.0)
        # An adapter's clock has an arbitrary zero: assume that the quickest frame did not wait.
        now = self._clock()
        gap = now - message.timestamp
        self._quickest_s = min(self._quickest_s + CLOCK_DRIFT * (now - self._quickest_at), gap)
        self._quickest_at = now
        return gap - self._quickest_s

    def _record(self, message: can.Message) -> None:
        if self._log is not None:
            message.channel = self.channel
            self._log.write(message)


def _filter(key: int) -> can.typechecking.CanFilter:
    extended = bool(key & EXTENDED)
    return {
        "can_id": key & ~EXTENDED,
        "can_mask": 0x1FFFFFFF if extended else 0x7FF,
        "extended": extended,
    }


def _is_junk(error: Exception) -> bool:
    """Return whether a datagram arrived that is no frame, while the bus itself works."""
    cause = error.__cause__
    return isinstance(error, can.CanOperationError) and not (
        error.error_code or cause is None or isinstance(cause, OSError)
    )
