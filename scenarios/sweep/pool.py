"""Runs the cases of a sweep on the cores of this computer."""

from __future__ import annotations

import atexit
import multiprocessing
import os
import threading
from collections.abc import Iterator, Mapping, Sequence
from concurrent.futures import FIRST_COMPLETED, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from pathlib import Path
from typing import Any

from measurement.stops import LOOK_S, blocking_stops, ending_work
from measurement.workers import begin
from scenarios.fmu_file import Shelf
from scenarios.sweep.case import failed, outcome_of
from scenarios.sweep.plan import Job

_shelf = Shelf()
"""Of a worker process."""
atexit.register(_shelf.close)

LOST = "its process ended twice without a result, the second time alone"


def cores() -> int:
    """Return the number of cores that this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def on_cores(
    jobs: Sequence[Job], places: Mapping[str, Path], workers: int
) -> Iterator[dict[str, Any]]:
    """Yield the outcome of every job once, in the order in which they end.

    Parameters
    ----------
    jobs : sequence of Job
    places : mapping of str to Path
        The FMUs by SHA-256.
    workers : int
        Processes; with one, the jobs run in this process.

    Raises
    ------
    BadInput
        If a case does not fit the FMUs.
    """
    if workers == 1:
        with Shelf() as shelf:
            for job in jobs:
                yield outcome_of(job, places, shelf)
        return
    left = {job.number: job for job in jobs}

    def ended(outcomes: Iterator[dict[str, Any]]) -> Iterator[dict[str, Any]]:
        for outcome in outcomes:
            del left[outcome["number"]]
            yield outcome

    while left:
        try:
            yield from ended(_one_pool(list(left.values()), places, workers))
        except BrokenProcessPool:
            # Jobs start in order, so the one that killed its process is among the first left.
            for suspect in list(left.values())[:workers]:
                try:
                    yield from ended(_one_pool([suspect], places, 1))
                except BrokenProcessPool:
                    yield from ended(iter([failed(suspect, LOST)]))


def _one_pool(
    jobs: Sequence[Job], places: Mapping[str, Path], workers: int
) -> Iterator[dict[str, Any]]:
    # New processes: a fork would share the FMUs' interpreter state and this process's threads.
    context = multiprocessing.get_context("spawn")
    pool = ProcessPoolExecutor(min(workers, len(jobs)), context, begin, (os.getpid(),))
    stopped = threading.Event()
    with ending_work(stopped.set):
        try:
            with blocking_stops():
                left = {pool.submit(_outcome, job, places) for job in jobs}
            while left and not stopped.is_set():
                done, left = wait(left, LOOK_S, FIRST_COMPLETED)
                yield from (future.result() for future in done)
        finally:
            pool.shutdown(cancel_futures=True)


def _outcome(job: Job, places: Mapping[str, Path]) -> dict[str, Any]:
    return outcome_of(job, places, _shelf)
