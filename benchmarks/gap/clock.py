"""Measures processor time and wall-clock time."""

from __future__ import annotations

import resource
import time
from collections.abc import Iterator
from contextlib import contextmanager


@contextmanager
def clocked() -> Iterator[dict[str, float]]:
    """Measure the time spent in the block, as ``cpu`` and ``wall`` [s].

    Processor time includes child processes that have ended.
    """
    spent = {"cpu": 0.0, "wall": 0.0}
    wall, cpu = time.perf_counter(), _cpu()
    yield spent
    spent["cpu"], spent["wall"] = _cpu() - cpu, time.perf_counter() - wall


def _cpu() -> float:
    both = [resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)]
    return sum(one.ru_utime + one.ru_stime for one in both)
