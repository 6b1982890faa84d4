"""Processes that end with what started them: done, interrupted, terminated or killed."""

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

from measurement.stops import LOOK_S, STOPS, ending_work


@contextmanager
def workers(count: int | None = None) -> Iterator[ProcessPoolExecutor]:
    """Give a pool of processes that does not outlive what is done with it.

    Parameters
    ----------
    count : int, optional
        Processes; by default one for each core.

    Yields
    ------
    ProcessPoolExecutor
        Its processes run one thread each.

    Notes
    -----
    The pool of the standard library waits on leaving for whatever its workers have begun. So the
    workers are ended first where something was raised, and by Ctrl-C and SIGTERM: nothing that they
    have begun is wanted any more.
    """
    before = set(multiprocessing.active_children())

    def end() -> None:
        _end(set(multiprocessing.active_children()) - before)
        # A worker that ends while it sends leaves the pool waiting for the rest, as long as anybody
        # could still write: this process, which never does.
        with suppress(AttributeError, OSError):
            pool._result_queue._writer.close()  # type: ignore[attr-defined]
        # And the thread that feeds workers waits until somebody reads, as long as anybody could:
        # this process, again. From 3.11.5 on the pool's own thread closes it, and must do so alone.
        if sys.version_info < (3, 11, 5):
            with suppress(AttributeError, OSError):
                pool._call_queue._reader.close()  # type: ignore[attr-defined]

    # One thread each: small matrices gain nothing from more, and workers would crowd each other.
    pool = ProcessPoolExecutor(count or os.cpu_count(), initializer=begin, initargs=(os.getpid(),))
    try:
        _start(pool)
        with ending_work(end):
            yield pool
            pool.shutdown()
    except BaseException:
        end()
        pool.shutdown(wait=False, cancel_futures=True)
        raise


def _start(pool: ProcessPoolExecutor) -> None:
    """Start the workers while no signal can reach them half begun."""
    # Windows has no signal masks, and begins processes that inherit no handlers.
    if not hasattr(signal, "pthread_sigmask"):
        pool.submit(_idle)
        return
    usual = signal.pthread_sigmask(signal.SIG_BLOCK, STOPS)
    try:
        pool.submit(_idle)
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, usual)


def _idle() -> None:
    """Do nothing: the first job makes the pool start its processes."""


def begin(parent: int) -> None:
    """Prepare a worker: it leaves Ctrl-C to its parent, and ends when told to or left alone.

    Parameters
    ----------
    parent : int
        The number of the process that it works for.
    """
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.signal(signal.SIGTERM, signal.SIG_DFL)
    if hasattr(signal, "pthread_sigmask"):
        signal.pthread_sigmask(signal.SIG_UNBLOCK, STOPS)
    threadpool_limits(1)
    threading.Thread(target=_end_with, args=(parent,), daemon=True).start()


def _end_with(parent: int) -> None:
    """End this process once its parent is gone, which no signal of its own tells it."""
    while os.getppid() == parent:
        time.sleep(LOOK_S)
    os._exit(1)


def _end(processes: set[multiprocessing.process.BaseProcess]) -> None:
    """End processes, by force those that do not go at once."""
    for process in processes:
        process.terminate()
    until = time.monotonic() + LOOK_S
    for process in processes:
        process.join(max(until - time.monotonic(), 0.0))
        if process.is_alive():
            process.kill()
            process.join()
