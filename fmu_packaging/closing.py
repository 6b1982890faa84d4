"""Shuts pythonfmu's binary down in order, which it does not do by itself.

When a process ends, the binary destroys its static state, and then its library destructor releases
that state a second time. Occasionally this aborts a process that had finished its work.
"""

from __future__ import annotations

import atexit
import ctypes
import sys
from pathlib import Path

_closing: set[str] = set()


def close_in_order(resources: Path) -> None:
    """Let the binary next to *resources* release its state when Python ends, if Python is the host.

    In other hosts the binary itself ends Python and must not be called during that.
    """
    if not sys.platform.startswith("linux") or not sys.orig_argv:
        return
    for path in (resources.parent / "binaries" / "linux64").glob("*.so"):
        if str(path) not in _closing:
            _closing.add(str(path))
            try:
                atexit.register(ctypes.CDLL(str(path)).finalizePythonInterpreter)
            except (AttributeError, OSError):
                return  # another binary without this function
