"""What a service manager wants to hear: ready, still alive, stopping (sd_notify(3)).

A datagram to the socket that ``NOTIFY_SOCKET`` names; nothing where there is none. The loop of the
gateway sends the signs of life itself, so that one which hangs is started anew.
"""

from __future__ import annotations

import contextlib
import os
import socket
from collections.abc import Mapping


class ServiceManager:
    """Tells a service manager how the program is.

    Parameters
    ----------
    environment : mapping, optional
        By default that of the process.

    Attributes
    ----------
    every_s : float
        How often it wants a sign of life: half of what it allows; infinite for never [s].
    """

    def __init__(self, environment: Mapping[str, str] = os.environ) -> None:
        address = environment.get("NOTIFY_SOCKET", "")
        # An @ stands for the zero byte of an abstract address.
        self._address = "\0" + address[1:] if address.startswith("@") else address
        self.every_s = float("inf")
        mine = environment.get("WATCHDOG_PID", str(os.getpid())) == str(os.getpid())
        with contextlib.suppress(ValueError):
            allowed_us = int(environment.get("WATCHDOG_USEC", "0"))
            if mine and allowed_us > 0:
                self.every_s = allowed_us / 2e6
        self._told_at = float("-inf")

    def tell(self, *lines: str) -> None:
        """Send assignments, such as ``READY=1``."""
        if not self._address:
            return
        with contextlib.suppress(OSError), socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as out:
            out.setblocking(False)
            out.sendto("\n".join(lines).encode(), self._address)

    def alive(self, now: float) -> None:
        """Send a sign of life if one is due at a time of any steady clock [s]."""
        if now - self._told_at >= self.every_s:
            self._told_at = now
            self.tell("WATCHDOG=1")
