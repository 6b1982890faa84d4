"""Ctrl-C and SIGTERM while other processes work for this one.

Python raises at whatever bytecode a signal finds. In the middle of a wait for a pool of processes
that leaves a lock of the pool's own threads taken, which then wait for it for ever; and a signal
that comes just before such a wait is not seen until the wait ends.
"""

from __future__ import annotations

import signal
import socket
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import FrameType
from typing import Any

STOPS = (signal.SIGINT, signal.SIGTERM)

LOOK_S = 0.5
"""How often a worker looks whether its parent is still there, who waits whether to end, and others
are shown how it is; how long a worker may take to end when told to, before it is killed; and how
soon a SIGTERM that got lost is sent again [s]. Set on no data."""

HOLDS_LOCKS = ("concurrent.futures", "multiprocessing", "threading")
"""Where nothing may be raised: modules that hold a lock which other threads wait for."""


@contextmanager
def ending_work(end: Callable[[], None]) -> Iterator[None]:
    """Let Ctrl-C and SIGTERM end the work of other processes, and then this one's.

    Parameters
    ----------
    end : callable
        Ends the work, so that whoever waits for it waits no longer. Called in another thread.

    Yields
    ------
    None

    Raises
    ------
    KeyboardInterrupt, SystemExit
        What the usual handlers raise: at once where no lock is held, else on leaving the block.

    Notes
    -----
    A signal that no function handles is left as it is. Outside the main thread, which no signal
    reaches, nothing is done.
    """
    handlers = {int(number): signal.getsignal(number) for number in STOPS}
    usual = {number: handler for number, handler in handlers.items() if callable(handler)}
    if threading.current_thread() is not threading.main_thread() or not usual:
        yield
        return
    depth = _depth(sys._getframe())
    waiting: list[int] = []

    def came(number: int, frame: FrameType | None) -> None:
        if _depth(frame) > depth:
            waiting.append(number)
        else:
            usual[number](number, frame)

    def watch() -> None:
        while numbers := inner.recv(16):
            if usual.keys() & set(numbers):
                end()

    outer, inner = socket.socketpair()
    outer.setblocking(False)
    watcher = threading.Thread(target=watch, daemon=True)
    for number in usual:
        signal.signal(number, came)
    woken = signal.set_wakeup_fd(outer.fileno(), warn_on_full_buffer=False)
    watcher.start()
    try:
        yield
    finally:
        signal.set_wakeup_fd(woken)
        for number, handler in usual.items():
            signal.signal(number, handler)
        outer.close()
        watcher.join()
        inner.close()
        if waiting:
            usual[waiting[0]](waiting[0], None)


def _depth(frame: FrameType | None) -> int:
    """Return how many calls on a stack are in modules that hold locks."""
    count = 0
    while frame is not None:
        name: Any = frame.f_globals.get("__name__", "")
        count += str(name).startswith(HOLDS_LOCKS)
        frame = frame.f_back
    return count
