"""This computer's clock that nobody sets."""

from __future__ import annotations

import time

_BOOT = getattr(time, "CLOCK_BOOTTIME", None)


def steady() -> float:
    """Return a time that never goes back and, where the system can, goes on in a suspend [s]."""
    return time.monotonic() if _BOOT is None else time.clock_gettime(_BOOT)
