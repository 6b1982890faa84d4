"""What may be slow or fail, beside the loop: a thread that does jobs in their order.

A disk that is full or hangs must not keep an answer waiting. So the loop hands its jobs over and
never waits; where the thread cannot follow, jobs are dropped and counted.
"""

from __future__ import annotations

import contextlib
import queue
import threading
import traceback
from collections.abc import Callable

Job = Callable[[], None]
LAST_S = 5.0
"""How long the end waits for what is left to do [s]."""


class Background:
    """A thread for jobs that the loop must not wait for.

    Parameters
    ----------
    room : int
        So many jobs may wait; a further one is dropped.
    idle : callable, optional
        Called about once a second by the thread, whether or not there are jobs.

    Attributes
    ----------
    dropped : int
        Jobs that found no room, or failed.
    """

    def __init__(self, room: int, idle: Job = lambda: None) -> None:
        self._jobs: queue.Queue[Job | None] = queue.Queue(room)
        self._idle = idle
        self.dropped = 0
        # A daemon: a job that hangs does not keep the program from ending.
        self._thread = threading.Thread(target=self._work, daemon=True)
        self._thread.start()

    def do(self, job: Job) -> bool:
        """Hand over a job; return whether there was room."""
        try:
            self._jobs.put_nowait(job)
        except queue.Full:
            self.dropped += 1
            return False
        return True

    def _work(self) -> None:
        while True:
            try:
                job = self._jobs.get(timeout=1.0)
            except queue.Empty:
                self._run(self._idle)
                continue
            if job is None:
                return
            self._run(job)

    def _run(self, job: Job) -> None:
        try:
            job()
        except Exception:
            # The jobs after it must be done all the same.
            self.dropped += 1
            with contextlib.suppress(OSError, ValueError):
                traceback.print_exc()

    def close(self) -> bool:
        """Do what is left, for a short while; return whether all was done."""
        try:
            self._jobs.put(None, timeout=LAST_S)
        except queue.Full:
            return False
        self._thread.join(LAST_S)
        return not self._thread.is_alive()
