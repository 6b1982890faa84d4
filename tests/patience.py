"""Waiting for what must come, however busy the machine is."""

import time
from collections.abc import Callable

PATIENCE_S = 500.0
"""Only what hangs takes as long [s]; a test that fails by it says where, before its own limit."""


def until(happened: Callable[[], object]) -> None:
    """Wait until something has happened; fail when it never does."""
    end = time.monotonic() + PATIENCE_S
    while not happened():
        assert time.monotonic() < end, f"this has not happened in {PATIENCE_S:g} s"
        time.sleep(0.02)
