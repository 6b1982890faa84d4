"""Notifies a service manager: ready, alive, stopping (sd_notify(3)).

Sends datagrams to the socket in ``NOTIFY_SOCKET``, if there is one. The gateway's main loop itself
sends the signs of life, so that a hanging gateway is restarted.
"""

from __future__ import annotations

import contextlib
import os
import socket
from collections.abc import Mapping


class ServiceManager:
    """Reports the program's condition to a service manager.

    Parameters
    ----------
    environment : mapping, optional
        By default that of the process.

    Attributes
    ----------
    every_s : float
        Period of the signs of life, half of the manager's timeout; infinite for none [s].
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
        """Send assignments, for example ``READY=1``."""
        if not self._address:
            return
        with contextlib.suppress(OSError), socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as out:
            out.setblocking(False)
            out.sendto("\n".join(lines).encode(), self._address)

    def alive(self, now: float) -> None:
        """Send a sign of life if one is due at *now*, of any monotonic clock [s]."""
        if now - self._told_at >= self.every_s:
            self._told_at = now
            self.tell("WATCHDOG=1")
