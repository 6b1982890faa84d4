"""An FMU at one end of the bus: values in and out by name, and a state that outlives the process.

The gateway may be restarted while the spindle is warm. What the compensator remembers (its
reference temperatures, its offsets) is therefore kept in a file, as the FMU itself serialises it.
"""

from __future__ import annotations

import base64
import io
import json
import os
import time
from collections.abc import Callable, Mapping, Sequence
from ctypes import byref, c_char, c_size_t, c_void_p
from dataclasses import dataclass
from math import isfinite, nan
from pathlib import Path
from typing import Any

from measurement.errors import BadInput
from measurement.files import read_bytes, write_atomically
from scenarios.fmu import WARNING, Port, Slave
from scenarios.outputs import STATE_KIND, begins_as_state
from scenarios.wiring import PROBED

FORMAT = 1
OLDEST_S = 3600.0
"""Oldest saved state that is restored [s]."""


class StatefulSlave(Slave):
    """An FMU whose state can be saved and restored."""

    @property
    def can_save(self) -> bool:
        """Whether the FMU says that its state can be serialised."""
        return bool(self.description.coSimulation.canSerializeFMUstate)

    def saved(self) -> bytes:
        """Return the state of the FMU.

        Raises
        ------
        FmuError
            If it gives none.
        """
        library, state, size = self.library, c_void_p(), c_size_t()
        self._ok(
            library.fmi2GetFMUstate(self.component, byref(state)), "it does not give its state"
        )
        try:
            problem = "its state cannot be serialised"
            status = library.fmi2SerializedFMUstateSize(self.component, state, byref(size))
            self._ok(status, problem)
            memory = (c_char * size.value)()
            status = library.fmi2SerializeFMUstate(self.component, state, memory, size)
            self._ok(status, problem)
            return bytes(memory)
        finally:
            library.fmi2FreeFMUstate(self.component, byref(state))

    def restore(self, data: bytes) -> None:
        """Take up what `saved` returned.

        Raises
        ------
        FmuError
            If the FMU refuses it.
        """
        library, state = self.library, c_void_p()
        memory = (c_char * len(data)).from_buffer_copy(data)
        problem = "it does not accept a saved state"
        status = library.fmi2DeSerializeFMUstate(
            self.component, memory, c_size_t(len(data)), byref(state)
        )
        self._ok(status, problem)
        try:
            self._ok(library.fmi2SetFMUstate(self.component, state), problem)
        finally:
            library.fmi2FreeFMUstate(self.component, byref(state))

    def _ok(self, status: int, problem: str) -> None:
        if status > WARNING:
            raise self.failure(problem)


@dataclass(frozen=True)
class Saved:
    """A state file: the FMU's time and the machine's [s], how long ago [s], and the state."""

    time_s: float
    machine_time_s: float
    age_s: float
    state: bytes


class StateFile:
    """Where an FMU's state is kept.

    Parameters
    ----------
    path : Path
        The file; written whole or not at all.
    fmu_sha256 : str
        The FMU that the state must belong to.
    wall : callable, optional
        The time of day [s].
    """

    def __init__(self, path: Path, fmu_sha256: str, wall: Callable[[], float] = time.time) -> None:
        self.path, self._fmu, self._wall = path, fmu_sha256, wall

    def now(self) -> float:
        """Return the time of day, for `write` [s]."""
        return self._wall()

    def write(self, taken: float, time_s: float, machine_time_s: float, state: bytes) -> None:
        """Save a state that was taken at a time of day [s].

        Raises
        ------
        BadInput
            If the file cannot be written.
        """
        table = {
            "kind": STATE_KIND,
            "format": FORMAT,
            "fmu": self._fmu,
            "pid": os.getpid(),
            "saved": taken,
            "time_s": time_s,
            "machine_time_s": machine_time_s,
            "state": base64.b64encode(state).decode(),
        }
        write_atomically(self.path, json.dumps(table) + "\n")

    def read(self, speed_up: float = 1.0) -> tuple[Saved | None, str]:
        """Return what was saved, or None and why it cannot be used.

        Parameters
        ----------
        speed_up : float
            Seconds of the FMU in a second of the time of day.

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
            if table["format"] != FORMAT:
                raise ValueError("it is of another version")
            state = base64.b64decode(table["state"], validate=True)
            saved, *times = (float(table[key]) for key in ("saved", "time_s", "machine_time_s"))
            if not all(map(isfinite, (saved, *times))):
                raise ValueError("a time in it is not a number")
        except (ValueError, KeyError, TypeError) as error:
            # A power cut may leave such a file; the gateway starts without it.
            return None, f"it is damaged: {error}"
        age = self._wall() - saved
        found = Saved(times[0], times[1], age, state)
        if table["fmu"] != self._fmu:
            return None, "it belongs to another FMU"
        if age < 0.0:
            return None, f"it was saved {-age:.0f} s in the future: this computer's clock was set"
        if age * speed_up > OLDEST_S:
            allowed = f"allowed is {OLDEST_S / speed_up:g} s"
            return None, f"it was saved {age:.0f} s ago, {allowed}"
        return found, ""


class CompensatorUnit:
    """The compensator FMU, stepped sample by sample.

    Parameters
    ----------
    path : Path
        The FMU.
    show : callable
        Takes each warning of the FMU, as a line.
    printed : StringIO, optional
        See `Slave`.

    Attributes
    ----------
    inputs : list of str
        The real inputs of the FMU, without those for a probe.
    probed : list of str
        Those for a probe, without the flag.
    outputs : dict of str to float
        Every output but texts, by name; ``valid`` and the status are numbers.
    time_s : float
        What the FMU has reached [s].
    """

    def __init__(
        self,
        path: Path,
        show: Callable[[str], None] = lambda line: None,
        printed: io.StringIO | None = None,
    ) -> None:
        self.slave = StatefulSlave(path, "compensator", show, printed or io.StringIO())
        named = self.slave.names("input")
        self.inputs = [name for name in named if not name.startswith(PROBED)]
        self._in = Port(self.slave, self.inputs)
        self.probed = [name for name in named if name.startswith(f"{PROBED}_")]
        self._probe = Port(self.slave, self.probed)
        flag = [PROBED] if self.probed else []
        self._flag = Port(self.slave, flag, "Boolean")
        kinds = ("Real", "Integer", "Boolean")
        self._ports = [Port(self.slave, self.slave.names("output", k), k) for k in kinds]
        self._texts = self.slave.names("output", "String")
        self._new: bytes | None = None
        self.time_s = 0.0
        self.outputs: dict[str, float] = {}

    @property
    def output_names(self) -> list[str]:
        """What `outputs` holds once it has started."""
        return [name for port in self._ports for name in port.names]

    def start(self, saved: Saved | None = None) -> None:
        """Initialise, and go on from a saved state if there is one.

        Parameters
        ----------
        saved : Saved, optional
            State and time of an earlier run of the same FMU.

        Raises
        ------
        FmuError
            If the FMU refuses.
        """
        with self.slave.starting(1e9):
            pass
        self._new = self.slave.saved() if self.slave.can_save else None
        if saved is not None:
            self.slave.restore(saved.state)
            self.time_s = saved.time_s
        self._read()

    def renew(self) -> None:
        """Forget everything: the next sample is the first.

        Raises
        ------
        FmuError
            If the FMU cannot go back to how it was when it started.
        """
        if self._new is None:
            raise self.slave.failure("it cannot take up an earlier state")
        self.slave.restore(self._new)
        self.time_s = 0.0
        self._read()

    def step(self, values: Mapping[str, float], step_s: float) -> dict[str, float]:
        """Take in one sample, NaN for what is missing, and advance by *step_s* [s].

        A probe counts where *values* holds all of it.

        Parameters
        ----------
        values : mapping of str to float
            By input, each in its unit; an input that is not in it is missing.
        step_s : float
            Length of the step [s].

        Returns
        -------
        dict of str to float
            All outputs after the step, by name.

        Raises
        ------
        FmuError
            If the FMU fails.
        """
        self._in.values[:] = [values.get(name, nan) for name in self.inputs]
        self._in.set()
        if self.probed:
            measured = all(name in values for name in self.probed)
            self._flag.values[0] = measured
            self._flag.set()
            if measured:
                self._probe.values[:] = [values[name] for name in self.probed]
                self._probe.set()
        self.slave.step(self.time_s, step_s)
        self.time_s += step_s
        self._read()
        return self.outputs

    def _read(self) -> None:
        for port in self._ports:
            port.get()
            self.outputs.update(zip(port.names, port.values.tolist(), strict=True))

    def text(self) -> str:
        """Return the status in the FMU's words."""
        return self.slave.text("status_text") if "status_text" in self._texts else ""

    def unit_of(self, name: str) -> str:
        """Return the unit of a variable; empty if it has none.

        Parameters
        ----------
        name : str
        """
        return str(self.slave.variables[name].unit or "")

    def close(self, error: BaseException | None = None) -> None:
        """Let the FMU go.

        Parameters
        ----------
        error : BaseException, optional
            What ended the gateway.
        """
        self.slave.__exit__(type(error) if error else None, error, None)


def check_units(source: Path, pairs: Sequence[tuple[str, str, str]]) -> None:
    """Refuse an FMU whose units are not those of the frames.

    Parameters
    ----------
    source : Path
        The FMU.
    pairs : sequence of (name, unit of the FMU, unit of the DBC)
        An FMU that names no unit passes.

    Raises
    ------
    BadInput
        For the first that differs.
    """
    for name, own, bus in units_that_differ(pairs):
        raise BadInput(source, name, f"is in {own}; the frames carry it in {bus}")


def units_that_differ(pairs: Sequence[tuple[str, str, str]]) -> list[tuple[str, str, str]]:
    """Return those pairs whose units are given and differ; see `check_units`."""
    return [(name, own, bus) for name, own, bus in pairs if own and bus and own != bus]


def options_of(texts: Sequence[str]) -> dict[str, Any]:
    """Return further settings of an interface from ``name=value`` texts; numbers become numbers.

    Parameters
    ----------
    texts : sequence of str
        As the command line has them.

    Raises
    ------
    BadInput
        For a text without an equals sign.
    """
    found: dict[str, Any] = {}
    for text in texts:
        name, mark, value = text.partition("=")
        if not mark or not name.strip():
            raise BadInput("--option", "", f"{text!r} is not of the form NAME=VALUE")
        try:
            found[name.strip()] = json.loads(value)
        except ValueError:
            found[name.strip()] = value
    return found
