"""Worker processes that end with their parent: finished, interrupted, terminated or killed."""

from __future__ import annotations

import multiprocessing
import os
import signal
import sys
import threading
import time
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from contextlib import contextmanager, suppress

from threadpoolctl import threadpool_limits

from measurement.stops import LOOK_S, STOPS, blocking_stops, ending_work


@contextmanager
def one_thread() -> Iterator[None]:
    """Let linear algebra run in one thread, and so give the same numbers on any number of cores.

    Small matrices gain nothing from more threads, which wait for each other at ten times the
    processor time where other processes run.

    Yields
    ------
    None
    """
    with threadpool_limits(1):
        yield


@contextmanager
def workers(count: int | None = None) -> Iterator[ProcessPoolExecutor]:
    """Give a process pool that does not outlive the block that uses it.

    Parameters
    ----------
    count : int, optional
        Number of processes; by default one per core.

    Yields
    ------
    ProcessPoolExecutor
        Its processes run one thread each.

    Notes
    -----
    On exit the pool of the standard library waits for work already begun. After an exception,
    Ctrl-C or SIGTERM that work is no longer wanted, so the workers are ended first.
    """
    before = set(multiprocessing.active_children())

    def end() -> None:
        _end(set(multiprocessing.active_children()) - before)
        # If a worker ends while sending, the pool waits for the rest as long as any process has the
        # pipe open for writing: this one has, but never writes.
        with suppress(AttributeError, OSError):
            pool._result_queue._writer.close()  # type: ignore[attr-defined]
        # Likewise the thread that feeds the workers waits as long as any process could read: again
        # this one. From 3.11.5 on the pool's own thread closes the pipe, and nobody else may.
        if sys.version_info < (3, 11, 5):
            with suppress(AttributeError, OSError):
                pool._call_queue._reader.close()  # type: ignore[attr-defined]

    pool = ProcessPoolExecutor(count or os.cpu_count(), initializer=begin, initargs=(os.getpid(),))
    try:
        with blocking_stops():
            pool.submit(_idle)
        with ending_work(end):
            yield pool
            pool.shutdown()
    except BaseException:
        end()
        # Wait for the pool's own thread: if it ended while the interpreter exits, both would use
        # the pipe between them, one to close it and one to write.
        pool.shutdown(cancel_futures=True)
        raise


def _idle() -> None:
    """Do nothing: the first job makes the pool start its processes."""


def begin(parent: int) -> None:
    """Prepare a worker: it ignores Ctrl-C, and ends on SIGTERM or when its parent is gone.

    Parameters
    ----------
    parent : int
        Process id of its parent.
    """
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.signal(signal.SIGTERM, signal.SIG_DFL)
    if hasattr(signal, "pthread_sigmask"):
        signal.pthread_sigmask(signal.SIG_UNBLOCK, STOPS)
    threadpool_limits(1)
    threading.Thread(target=_end_with, args=(parent,), daemon=True).start()


def _end_with(parent: int) -> None:
    """End this process once its parent is gone; no signal reports that."""
    while os.getppid() == parent:
        time.sleep(LOOK_S)
    os._exit(1)


def _end(processes: set[multiprocessing.process.BaseProcess]) -> None:
    """End processes; kill those that do not end at once."""
    for process in processes:
        process.terminate()
    until = time.monotonic() + LOOK_S
    for process in processes:
        process.join(max(until - time.monotonic(), 0.0))
        if process.is_alive():
            process.kill()
            process.join()
