"""The master's loop in C: the same calls as in Python, in the same order, on the same memory.

Moving some 40 numbers between two FMUs costs Python more than both compute, if these are in C. The
loop itself, `loop.c`, knows nothing of a scenario: it has the ports, tables and signals of the loop
in Python, and what acts on a sensor at which point. Both loops give the same bits.
"""

from __future__ import annotations

import ctypes
import tempfile
from ctypes import Structure, c_double, c_int32, c_size_t, c_void_p
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fmu_packaging.native.build import HEADERS
from fmu_packaging.native.compilers import CompileError, Compiler, NativeError, compilers
from scenarios.faults import FaultLine
from scenarios.fmu import Port, Slave
from scenarios.signals.base import FloatArray

SOURCE = Path(__file__).resolve().with_name("loop.c")
REACHED, CHANGED = 0, 1
"""Outcomes: given by the loop in C."""
NONE = c_size_t(-1).value


class _Moved(Structure):
    _fields_ = (("refs", c_void_p), ("count", c_size_t), ("values", c_void_p))


class _Fmu(Structure):
    _fields_ = tuple(
        (name, c_void_p)
        for name in ("component", "step", "set", "get", "get_integer", "get_boolean")
    )


class _Fault(Structure):
    _fields_ = (
        ("place", c_size_t),
        ("acts", c_void_p),
        ("values", c_void_p),
        ("held", c_double),
        ("holds", c_int32),
    )


class _Loop(Structure):
    _fields_ = (
        *((name, c_size_t) for name in ("steps", "k")),
        ("step_s", c_double),
        ("time_s", c_void_p),
        *((name, _Fmu) for name in ("plant", "compensator")),
        *((name, _Moved) for name in ("plant_in", "plant_out", "seen_in", "sent")),
        *((name, _Moved) for name in ("codes", "flags")),
        *((name, c_size_t) for name in ("driven", "told", "measured", "offsets", "faults")),
        *((name, c_void_p) for name in ("plant_rows", "seen_rows", "take", "give", "fault")),
        *((f"{name}_table", c_void_p) for name in ("plant", "seen", "sent", "code")),
        *((name, c_size_t) for name in ("status", "sensor")),
        *((name, c_int32) for name in ("noted", "last_status", "last_sensor", "call", "said")),
    )


@dataclass(frozen=True)
class Compensated:
    """The compensator's part of a loop.

    Attributes
    ----------
    slave : Slave
    ports : tuple of Port
        Its inputs; its real, integer and Boolean outputs.
    chosen : tuple of ndarray of int
        Which of the plant's outputs it sees, and which of its own are the plant's offsets.
    rows : ndarray
        The signals that it is told, (points, signals).
    faults : FaultLine
    tables : tuple of ndarray
        To be filled with inputs, real outputs and the others, (points, variables).
    codes : tuple of int or None
        Places among the integers of the status and the sensor, whose change is an event.
    """

    slave: Slave
    ports: tuple[Port, Port, Port, Port]
    chosen: tuple[NDArray[Any], NDArray[Any]]
    rows: FloatArray
    faults: FaultLine
    tables: tuple[FloatArray, FloatArray, FloatArray]
    codes: tuple[int | None, int | None]


@cache
def _library(compiler: Compiler) -> ctypes.CDLL | None:
    """Return the loop, compiled; None if that fails."""
    names = ("fmi2FunctionTypes.h", "fmi2TypesPlatform.h")
    sources = {name: (HEADERS / name).read_text("utf-8") for name in names}
    sources[SOURCE.name] = SOURCE.read_text("utf-8")
    # A library that is loaded cannot be removed everywhere.
    with tempfile.TemporaryDirectory(prefix="spindle-drift-loop-", ignore_cleanup_errors=True) as f:
        path = Path(f) / f"loop{compiler.suffix}"
        try:
            path.write_bytes(compiler.library(sources))
            library = ctypes.CDLL(str(path))
        except (CompileError, OSError):
            return None
    library.loop_run.argtypes = [ctypes.POINTER(_Loop), c_size_t]
    library.loop_run.restype = c_int32
    assert c_size_t.in_dll(library, "loop_size").value == ctypes.sizeof(_Loop)
    return library


class LoopInC:
    """A loop that C runs.

    Parameters
    ----------
    library : ctypes library
    plant : Slave
    ports : tuple of Port
        The plant's inputs and outputs.
    time_s : ndarray
        The communication points [s], evenly spaced.
    step_s : float
        Between two of them [s].
    rows : ndarray
        The signals that drive the plant, (points, signals).
    table : ndarray
        To be filled with the plant's outputs, (points, outputs).
    compensated : Compensated or None
    """

    def __init__(
        self,
        library: ctypes.CDLL,
        plant: Slave,
        ports: tuple[Port, Port],
        time_s: FloatArray,
        step_s: float,
        rows: FloatArray,
        table: FloatArray,
        compensated: Compensated | None,
    ) -> None:
        self._run, self._time_s = library.loop_run, time_s
        self._kept: list[Any] = [ports, compensated]  # C has their addresses only
        self._state = state = _Loop(steps=len(time_s) - 1, step_s=step_s, status=NONE, sensor=NONE)
        state.time_s = self._address(time_s)
        state.plant, state.driven = _fmu(plant), rows.shape[1]
        state.plant_in, state.plant_out = map(_moved, ports)
        state.plant_rows, state.plant_table = self._address(rows), self._address(table)
        # In the order of loop.c's enum call.
        self._calls: list[tuple[Port | Slave, str]] = list(zip(ports, ("set", "read"), strict=True))
        self._calls.append((plant, "step"))
        plant.moment = self.now
        if compensated is not None:
            self._connect(state, compensated)

    def _connect(self, state: _Loop, other: Compensated) -> None:
        state.compensator, state.told = _fmu(other.slave), other.rows.shape[1]
        state.seen_in, state.sent, state.codes, state.flags = map(_moved, other.ports)
        take, give = (np.ascontiguousarray(places, dtype=np.uintp) for places in other.chosen)
        state.measured, state.offsets = len(take), len(give)
        state.take, state.give = self._address(take), self._address(give)
        state.seen_rows = self._address(other.rows)
        state.seen_table, state.sent_table, state.code_table = map(self._address, other.tables)
        state.status, state.sensor = (NONE if code is None else code for code in other.codes)
        acting = other.faults.over(self._time_s, state.step_s)
        faults = (_Fault * len(acting))()
        for fault, (place, acts, values) in zip(faults, acting, strict=True):
            fault.place = place
            fault.acts, fault.values = self._address(acts), self._address(values)
        self._kept.append(faults)
        state.faults, state.fault = len(acting), ctypes.addressof(faults)
        self._calls += zip(other.ports, ("set", "read", "read", "read"), strict=True)
        self._calls.append((other.slave, "step"))
        other.slave.moment = self.now

    def _address(self, values: NDArray[Any]) -> int:
        assert values.flags.c_contiguous
        self._kept.append(values)
        return int(values.ctypes.data)

    def now(self) -> float:
        """Return the time of the point that has been reached [s]."""
        return float(self._time_s[min(self._state.k, len(self._time_s) - 1)])

    def run(self, end: int) -> int | None:
        """Go on to a point; beyond the last, that one is recorded, too.

        Returns
        -------
        int or None
            The point at which the status changed, and from which the next call goes on; None when
            *end* has been reached.

        Raises
        ------
        FmuError
            If an FMU fails.
        """
        outcome = self._run(ctypes.byref(self._state), end)
        if outcome == REACHED:
            return None
        if outcome == CHANGED:
            return int(self._state.k)
        what, word = self._calls[self._state.call]
        if isinstance(what, Port):
            raise what.failure(word)
        raise what.step_failure(self._state.said)


def _moved(port: Port) -> _Moved:
    return _Moved(port.references, len(port.names), port.values.ctypes.data)


def _fmu(slave: Slave) -> _Fmu:
    names = ("DoStep", "SetReal", "GetReal", "GetInteger", "GetBoolean")
    calls = [ctypes.cast(getattr(slave.library, f"fmi2{name}"), c_void_p).value for name in names]
    return _Fmu(slave.component, *calls)


def library() -> ctypes.CDLL | None:
    """Return the loop as this machine's compiler makes it; None without one."""
    try:
        return _library(compilers()[0])
    except NativeError:
        return None
