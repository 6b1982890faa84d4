"""A thread that runs jobs which may be slow or fail, in order.

A full or hanging disk must not delay an answer. So the main loop hands such jobs over and never
waits; if the thread cannot keep up, jobs are dropped and counted.
"""

from __future__ import annotations

import contextlib
import queue
import threading
import traceback
from collections.abc import Callable

Job = Callable[[], None]
ROOM = 20_000
"""Largest number of waiting jobs: nearly three minutes of writing 120 frames a second. Set on no
data."""
LAST_S = 5.0
"""Longest wait for the remaining jobs at the end [s]: set on no data."""


class Background:
    """Runs jobs that the main loop must not wait for.

    Parameters
    ----------
    room : int
        Largest number of waiting jobs; further ones are dropped.
    idle : callable, optional
        Called about once a second by the thread, whether or not there are jobs.

    Attributes
    ----------
    dropped : int
        Jobs that were dropped or failed.
    """

    def __init__(self, room: int = ROOM, idle: Job = lambda: None) -> None:
        self._jobs: queue.Queue[Job | None] = queue.Queue(room)
        self._idle = idle
        self.dropped = 0
        # A daemon, so that a hanging job does not keep the program from ending.
        self._thread = threading.Thread(target=self._work, daemon=True)
        self._thread.start()

    def do(self, job: Job) -> bool:
        """Hand over a job.

        Parameters
        ----------
        job : callable

        Returns
        -------
        bool
            Whether there was room.
        """
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
            # Later jobs must still be done.
            self.dropped += 1
            with contextlib.suppress(OSError, ValueError):
                traceback.print_exc()

    def close(self) -> bool:
        """Finish the remaining jobs within `LAST_S`; return whether all were done."""
        try:
            self._jobs.put(None, timeout=LAST_S)
        except queue.Full:
            return False
        self._thread.join(LAST_S)
        return not self._thread.is_alive()
