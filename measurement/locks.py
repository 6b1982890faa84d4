"""Locks by which processes wait for each other, on Linux and macOS."""

from __future__ import annotations

import contextlib

try:
    import fcntl
except ImportError:  # on other systems nothing is locked
    fcntl = None  # type: ignore[assignment]


def lock(handle: int, *, wait: bool = True) -> bool:
    """Lock an open file or folder until it is closed; return whether it is locked.

    Parameters
    ----------
    handle : int
    wait : bool
        Wait until the lock is free, instead of returning at once.
    """
    if fcntl is None:
        return False
    with contextlib.suppress(OSError):  # not free, or a network file system without locks
        fcntl.flock(handle, fcntl.LOCK_EX if wait else fcntl.LOCK_EX | fcntl.LOCK_NB)
        return True
    return False
