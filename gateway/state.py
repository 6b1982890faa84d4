"""Saves an FMU's state, so that it survives a restart.

The gateway may be restarted while the spindle is warm. So the compensator's state (reference
temperatures, offsets) is kept in a file, as serialised by the FMU itself.
"""

from __future__ import annotations

import base64
import json
import os
import time
from collections.abc import Callable
from dataclasses import dataclass
from math import isfinite
from pathlib import Path

from measurement.errors import BadInput
from measurement.files import read_bytes, write_atomically
from scenarios.outputs import STATE_KIND, begins_as_state

GATEWAY_STATE = 1
"""Format of the state file: given by this version."""
OLDEST_S = 3600.0
"""Largest age of a saved state that is restored [s]: set on no data."""


@dataclass(frozen=True)
class Saved:
    """A saved state: the FMU's and the machine's time [s], its age [s], and its bytes."""

    time_s: float
    machine_time_s: float
    age_s: float
    state: bytes


class StateFile:
    """The file that keeps an FMU's state.

    Parameters
    ----------
    path : Path
        The file; written completely or not at all.
    fmu_sha256 : str
        Hash of the FMU that the state must belong to.
    wall : callable, optional
        The time of day [s].
    """

    def __init__(self, path: Path, fmu_sha256: str, wall: Callable[[], float] = time.time) -> None:
        self.path, self._fmu, self._wall = path, fmu_sha256, wall

    def now(self) -> float:
        """Return the time of day, for `write` [s]."""
        return self._wall()

    def write(self, taken: float, time_s: float, machine_time_s: float, state: bytes) -> None:
        """Save a state taken at the time of day *taken* [s].

        Raises
        ------
        BadInput
            If the file cannot be written.
        """
        table = {
            "kind": STATE_KIND,
            "format": GATEWAY_STATE,
            "fmu": self._fmu,
            "pid": os.getpid(),
            "saved": taken,
            "time_s": time_s,
            "machine_time_s": machine_time_s,
            "state": base64.b64encode(state).decode(),
        }
        write_atomically(self.path, json.dumps(table) + "\n")

    def read(self, speed_up: float = 1.0) -> tuple[Saved | None, str]:
        """Return the saved state and an empty text, or None and why it cannot be used.

        Parameters
        ----------
        speed_up : float
            Seconds of the FMU per second of the time of day.

        Raises
        ------
        BadInput
            If the file is not a state file.
        """
        if not self.path.exists():
            return None, "the file does not exist yet"
        if not self.path.is_file():
            raise BadInput(self.path, "", "is not an ordinary file")
        text = read_bytes(self.path)
        if not begins_as_state(text):
            raise BadInput(self.path, "", "is not a state of an FMU")
        try:
            table = json.loads(text)
            if table["format"] != GATEWAY_STATE:
                raise ValueError("it is of another version")
            state = base64.b64decode(table["state"], validate=True)
            saved, *times = (float(table[key]) for key in ("saved", "time_s", "machine_time_s"))
            if not all(map(isfinite, (saved, *times))):
                raise ValueError("a time in it is not a number")
        except (ValueError, KeyError, TypeError) as error:
            # A power cut may leave a damaged file; the gateway starts without it.
            return None, f"it is damaged: {error}"
        age = self._wall() - saved
        restorable = Saved(times[0], times[1], age, state)
        if table["fmu"] != self._fmu:
            return None, "it belongs to another FMU"
        if age < 0.0:
            return None, f"it was saved {-age:.0f} s in the future: this computer's clock was set"
        if age * speed_up > OLDEST_S:
            allowed = f"allowed is {OLDEST_S / speed_up:g} s"
            return None, f"it was saved {age:.0f} s ago, {allowed}"
        return restorable, ""
