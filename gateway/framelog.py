"""The log of frames, written by a separate thread so that it never stops the gateway.

If the disk is full or the file cannot be written, frames are dropped and counted, and writing is
tried again later. The log is flushed every `LOOK_S`, so a killed program loses about that.
"""

from __future__ import annotations

import contextlib
import os
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import can
from can.io.blf import FILE_HEADER_STRUCT
from can.util import channel2int

from gateway.background import Background
from measurement.errors import BadInput, one_line
from measurement.stops import LOOK_S

LOGS = (".log", ".asc", ".blf")
LARGEST_MB = 100.0
"""Size at which a log is rotated [MB]: set on no data."""
CHANNELS = 254
"""Highest channel in a log that numbers its buses in one byte: given by the formats."""
KEPT_LOGS = 9
"""Number of older logs kept, of which FILE.1 is the newest: set on no data."""


class FrameLog:
    """Writes frames to a file from a separate thread.

    Parameters
    ----------
    path : Path
        The log; its ending gives the format. An existing log is kept.
    say : callable, optional
        Takes a line for people.
    largest_mb : float, optional
        A larger log is rotated [MB].

    Raises
    ------
    BadInput
        If the ending names no format.
    """

    def __init__(
        self,
        path: Path,
        say: Callable[[str], None] = lambda line: None,
        largest_mb: float = LARGEST_MB,
    ) -> None:
        if path.suffix.lower() not in LOGS:
            raise BadInput(path, "", f"its ending must be one of {', '.join(LOGS)}")
        self.path, self._say, self._largest = path, say, largest_mb * 1e6
        self._lost, self._retry_at, self._synced_at = 0, 0.0, time.monotonic()
        self._writer: Any = None
        self._reopen = self._failing = False
        try:
            self._open()
        except (OSError, ValueError) as error:
            self._fail(error)
        self._thread = Background(idle=self._look)

    def write(self, message: can.Message) -> None:
        """Take a frame for the thread to write."""
        if self.path.suffix.lower() != ".log" and (channel2int(message.channel) or 0) > CHANNELS:
            message.channel = 0  # these formats number channels only up to CHANNELS
        self._thread.do(lambda: self._write(message))

    def reopen(self) -> bool:
        """Begin a new file, if the old one was renamed; return true, because it will be done."""
        self._reopen = True
        return True

    def close(self) -> None:
        """Write the remaining frames and close the file; give up on a file that hangs."""
        self._thread.do(self._close)
        done = self._thread.close()
        lost = self._lost + self._thread.dropped
        if lost or not done:
            self._say(f"{self.path}: {lost} frames were not logged" + ("" if done else " or more"))

    # In the thread

    def _write(self, message: can.Message) -> None:
        if self._writer is None and not self._open_again():
            self._lost += 1
            return
        if self.path.suffix.lower() == ".asc":
            # Received frames carry the kernel's time and may be older than the first one sent; the
            # writer subtracts its start only from later times.
            message.timestamp = max(message.timestamp, self._writer.started)
        try:
            self._writer.on_message_received(message)
        except (OSError, ValueError) as error:
            self._lost += 1
            self._fail(error)
        self._look()

    def _look(self) -> None:
        """Flush every `LOOK_S`, and check whether the file is still the same."""
        now = time.monotonic()
        if now - self._synced_at < LOOK_S and not self._reopen:
            return
        self._synced_at = now
        if self._writer is None:
            self._open_again()
            return
        try:
            self._sync()
            if self._failing:
                self._failing = False
                self._say(f"{self.path}: written again; {self._lost} frames were not")
            if self._reopen or not self._is_there():
                self._reopen = False
                self._writer.stop()
                self._open()
            elif self.path.stat().st_size > self._largest:
                self._writer.stop()
                self._turn_over()
                self._open()
        except (OSError, ValueError) as error:
            self._fail(error)

    def _open(self) -> None:
        self.path.parent.mkdir(parents=True, exist_ok=True)
        there = self.path.exists() and self.path.stat().st_size > 0
        if there and self.path.is_file():
            _trim(self.path)
        if there and self.path.suffix.lower() == ".asc":
            # The writer cannot append to this format.
            self._turn_over()
            there = False
        more = {} if self.path.suffix.lower() == ".asc" else {"append": there}
        self._writer = can.Logger(str(self.path), **more)
        self._file_id = self._identity()

    def _open_again(self) -> bool:
        now = time.monotonic()
        if now < self._retry_at:
            return False
        try:
            self._open()
        except (OSError, ValueError):
            self._retry_at = now + LOOK_S
            return False
        self._synced_at = float("-inf")  # flush at once: a full disk may still open a file
        return True

    def _sync(self) -> None:
        if self.path.suffix.lower() == ".blf":
            # Without an updated header a reader takes the file for empty.
            self._writer.stop()
            self._writer = can.Logger(str(self.path), append=True)
        else:
            self._writer.file.flush()

    def _stop(self) -> None:
        writer, self._writer = self._writer, None
        if writer is not None:
            with contextlib.suppress(OSError, ValueError):
                writer.stop()

    def _fail(self, error: Exception) -> None:
        self._stop()
        self._retry_at = time.monotonic() + LOOK_S
        if not self._failing:
            what = f"cannot be written: {one_line(error)}; the gateway goes on without"
            self._say(f"{self.path}: {what}")
        self._failing = True

    def _close(self) -> None:
        self._stop()
        self._retry_at = float("inf")

    def _identity(self) -> tuple[int, int]:
        status = os.stat(self.path)
        return status.st_dev, status.st_ino

    def _is_there(self) -> bool:
        try:
            return self._identity() == self._file_id
        except FileNotFoundError:
            return False

    def _turn_over(self) -> None:
        for number in range(KEPT_LOGS, 0, -1):
            older = self.path.with_name(f"{self.path.stem}.{number}{self.path.suffix}")
            newer = self.path.with_name(f"{self.path.stem}.{number - 1}{self.path.suffix}")
            newer = self.path if number == 1 else newer
            if newer.exists():
                newer.replace(older)


def _trim(path: Path) -> None:
    """Cut off an incomplete frame at the end, which a killed program may have left."""
    with path.open("rb+") as stream:
        size = stream.seek(0, os.SEEK_END)
        whole = size
        if path.suffix.lower() == ".blf":
            stream.seek(0)
            header = stream.read(FILE_HEADER_STRUCT.size)
            if len(header) == FILE_HEADER_STRUCT.size and header.startswith(b"LOGG"):
                whole = FILE_HEADER_STRUCT.unpack(header)[10]
        elif path.suffix.lower() == ".log":
            stream.seek(max(0, size - 4096))
            tail = stream.read()
            whole = size - len(tail) + tail.rfind(b"\n") + 1
        if 0 < whole < size:
            stream.truncate(whole)
