"""Handles Ctrl-C and SIGTERM while other processes work for this one.

Python raises at any bytecode. If a signal arrives during a wait for a process pool, the exception
leaves a lock taken that the pool's own threads then wait for forever; a signal just before such a
wait is not noticed until the wait ends.
"""

from __future__ import annotations

import signal
import socket
import sys
import threading
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from types import FrameType
from typing import Any

STOPS = (signal.SIGINT, signal.SIGTERM)

LOOK_S = 0.5
"""How often a worker checks for its parent, a waiting process whether to end, and progress is
shown; how long a worker may take to end before it is killed; how soon a lost SIGTERM is sent again;
and how often a log of frames is flushed, or tried again after a failure [s]. Set on no data."""

HOLDS_LOCKS = ("concurrent.futures", "multiprocessing", "threading")
"""Modules in which nothing may be raised, because they hold locks that other threads wait for."""


@contextmanager
def on_signals(names: Iterable[str], do: Callable[[int, Any], None]) -> Iterator[None]:
    """Call a function on those signals that the system supports.

    Parameters
    ----------
    names : iterable of str
        For example ``SIGUSR1``.
    do : callable
        Called in the main thread; must return soon.

    Yields
    ------
    None
        While the function handles the signals.
    """
    numbers = [getattr(signal, name) for name in names if hasattr(signal, name)]
    kept = {number: signal.signal(number, do) for number in numbers}
    try:
        yield
    finally:
        for number, handler in kept.items():
            signal.signal(number, handler)


@contextmanager
def blocking_stops() -> Iterator[None]:
    """Block `STOPS` while processes start, which inherit that: none then arrives in their start-up.

    Yields
    ------
    None
    """
    # Windows has no signal masks, and its new processes inherit no handlers.
    if not hasattr(signal, "pthread_sigmask"):
        yield
        return
    before = signal.pthread_sigmask(signal.SIG_BLOCK, STOPS)
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


@contextmanager
def ending_work(end: Callable[[], None]) -> Iterator[None]:
    """Let Ctrl-C and SIGTERM end the work of other processes, and then this one's.

    Parameters
    ----------
    end : callable
        Ends the work and so the wait for it. Called in another thread.

    Yields
    ------
    None

    Raises
    ------
    KeyboardInterrupt, SystemExit
        What the usual handlers raise: at once if no lock is held, else on leaving the block.

    Notes
    -----
    A signal without a Python handler is left alone. Outside the main thread, which signals do not
    reach, nothing is done.
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
    """Return the number of calls on a stack that are in modules that hold locks."""
    count = 0
    while frame is not None:
        name: Any = frame.f_globals.get("__name__", "")
        count += str(name).startswith(HOLDS_LOCKS)
        frame = frame.f_back
    return count
