"""An FMU as the master uses it: opened, connected by name, stepped with little overhead.

The arrays passed to C are made once: a port is a numpy array whose memory the FMU reads or writes,
so a step needs no conversion.
"""

from __future__ import annotations

import contextlib
import ctypes
import io
import signal
import sys
import threading
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from types import TracebackType
from typing import Any

import fmpy
import numpy as np
from fmpy.fmi1 import FMICallException, printLogMessage
from fmpy.fmi2 import (
    FMU2Slave,
    fmi2CallbackAllocateMemoryTYPE,
    fmi2CallbackFreeMemoryTYPE,
    fmi2CallbackFunctions,
    fmi2CallbackLoggerTYPE,
    fmi2Warning,
)
from fmpy.logging import addLoggerProxy
from numpy.typing import NDArray

from fmu_packaging.units import own_name
from measurement.errors import one_line
from measurement.stops import on_signals
from measurement.units import UNITS
from scenarios.fmu_file import FmuFile
from scenarios.wiring import check_role, names_of, parameter_kind

STATUS = ("ok", "warning", "discard", "error", "fatal", "pending")
_logs: dict[str, Callable[[int, str], None]] = {}


class FmuError(Exception):
    """An FMU failed while running; the text is one line: which, when, and the cause it logged."""


def _dispatch(component: Any, instance: bytes, status: int, category: bytes, text: bytes) -> None:
    """Pass a message to the slave that it comes from."""
    log = _logs.get(instance.decode("utf-8", "replace") if instance else "")
    if log is None:
        printLogMessage(component, instance, status, category, text)
    else:
        log(status, text.decode("utf-8", "replace"))


def _new_callbacks() -> Any:
    callbacks = fmi2CallbackFunctions()
    callbacks.logger = fmi2CallbackLoggerTYPE(_dispatch)
    callbacks.allocateMemory = fmi2CallbackAllocateMemoryTYPE(fmpy.calloc)
    callbacks.freeMemory = fmi2CallbackFreeMemoryTYPE(fmpy.free)
    # The proxy fills in a message's arguments, which Python cannot; one logger per process.
    addLoggerProxy(ctypes.byref(callbacks))
    return callbacks


_callbacks = _new_callbacks()


class Port:
    """Some variables of one type, moved together.

    Parameters
    ----------
    slave : Slave
    names : sequence of str
        Variables, all of one type; may be empty.
    kind : {"Real", "Integer", "Boolean"}
        Their type.

    Attributes
    ----------
    names : tuple of str
        The variables.
    values : ndarray
        The values last read, or to be set; shape (variables,).
    """

    def __init__(self, slave: Slave, names: Sequence[str], kind: str = "Real") -> None:
        self.names = tuple(names)
        number, element = (
            (np.float64, ctypes.c_double) if kind == "Real" else (np.int32, ctypes.c_int)
        )
        self.values: NDArray[Any] = np.zeros(len(self.names), dtype=number)
        self._slave, self._kind = slave, kind
        count = len(self.names)
        references = [int(slave.variables[name].valueReference) for name in self.names]
        memory = (element * count).from_buffer(self.values.data) if count else None
        self._call = (slave.component, (ctypes.c_uint * count)(*references), count, memory)
        self._getter = getattr(slave.library, f"fmi2Get{kind}")
        self._setter = getattr(slave.library, f"fmi2Set{kind}")

    def get(self) -> None:
        """Read the FMU's values into *values*."""
        if self.names and self._getter(*self._call) > fmi2Warning:
            raise self._failure("read")

    def set(self) -> None:
        """Set *values* in the FMU."""
        if self.names and self._setter(*self._call) > fmi2Warning:
            raise self._failure("set")

    def _failure(self, word: str) -> FmuError:
        return self._slave.failure(f"{', '.join(self.names[:3])} … could not be {word}")


class Slave:
    """An FMU for co-simulation (FMI 2.0), unpacked and instantiated; use it in a ``with``.

    Parameters
    ----------
    file : Path or FmuFile
        The ``.fmu`` file; an unpacked one stays unpacked.
    label : str
        Name in messages: ``plant`` or ``compensator``.
    show : callable
        Called with each warning of the FMU, as a line.
    printed : StringIO
        Standard error of the process meanwhile, in which an FMU that logs nothing may have left a
        cause.

    Raises
    ------
    BadInput
        If the file is not such an FMU, or lacks what a plant or a compensator must have.
    FmuError
        If it cannot be instantiated.
    """

    def __init__(
        self, file: Path | FmuFile, label: str, show: Callable[[str], None], printed: io.StringIO
    ) -> None:
        with contextlib.ExitStack() as stack:
            if isinstance(file, Path):
                file = FmuFile(file)
                stack.callback(file.remove)
            self.path, self.label, self._show = file.path, label, show
            self.description, self.sha256 = file.description, file.sha256
            self.variables = {entry.name: entry for entry in self.description.modelVariables}
            self.time_s = 0.0
            self._messages: list[str] = []
            self._printed = printed
            check_role(label, self.variables, self.path)
            instance = f"{label}-{id(self)}"
            _logs[instance] = self._log
            stack.callback(_logs.pop, instance, None)
            try:
                self._fmu = FMU2Slave(
                    guid=self.description.guid,
                    modelIdentifier=self.description.coSimulation.modelIdentifier,
                    unzipDirectory=str(file.folder),
                    instanceName=instance,
                )
                self._fmu.instantiate(callbacks=_callbacks, loggingOn=True)
            except Exception as error:
                cause = self._cause() or one_line(error)
                raise FmuError(f"{label} ({self.path}) cannot be started: {cause}") from None
            self._stack = stack.pop_all()
        self.component, self.library = self._fmu.component, self._fmu.dll
        self._do_step = self.library.fmi2DoStep

    def __enter__(self) -> Slave:
        """Return the slave."""
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        """End the simulation and remove what was unpacked."""
        with self._stack:
            with contextlib.suppress(FMICallException):
                if error is None:
                    self._fmu.terminate()
            self._fmu.freeInstance()

    # What it offers

    def names(self, causality: str, kind: str = "Real") -> list[str]:
        """Return the variables of a causality and a type, in the FMU's order.

        Parameters
        ----------
        causality : str
            Such as ``input``, ``output`` or ``parameter``.
        kind : str
            Such as ``Real``.
        """
        return names_of(self.variables, causality, kind)

    def column(self, name: str) -> str:
        """Return the column of a variable in a table: its name and unit.

        Parameters
        ----------
        name : str
            A variable; a unit that columns cannot have counts as none.
        """
        unit = own_name(self.variables[name].unit or "1")
        return f"{name}_{unit if unit in UNITS else '1'}"

    # Its life

    def set_parameter(self, name: str, value: float, source: str | Path, place: str) -> None:
        """Set a parameter before the start.

        Parameters
        ----------
        name : str
        value : float
            In the parameter's unit; 0 or 1 for a Boolean.
        source : str or path
            Where the value was given, for refusals.
        place : str
            Place in the source.

        Raises
        ------
        BadInput
            If the FMU has no such parameter, or does not accept the value.
        """
        kind = parameter_kind(self.label, self.variables, name, value, source, place)
        port = Port(self, [name], kind)
        port.values[0] = value
        port.set()

    @contextlib.contextmanager
    def starting(self, stop_s: float) -> Iterator[None]:
        """Initialise the FMU; the block runs in initialisation mode.

        Parameters
        ----------
        stop_s : float
            Stop time of the experiment [s].

        Yields
        ------
        None

        Raises
        ------
        FmuError
            If the FMU refuses its parameters or its first inputs.
        """
        try:
            self._fmu.setupExperiment(startTime=0.0, stopTime=stop_s)
            self._fmu.enterInitializationMode()
            yield
            self._fmu.exitInitializationMode()
        except FMICallException as error:
            raise self.failure(f"it did not start ({error.function})") from None

    def step(self, time_s: float, step_s: float) -> None:
        """Advance from *time_s* by *step_s* [s].

        Parameters
        ----------
        time_s : float
            Start of the step [s].
        step_s : float
            Length of the step [s].

        Raises
        ------
        FmuError
            If the FMU fails.
        """
        self.time_s = time_s
        status = self._do_step(self.component, time_s, step_s, 1)
        if status > fmi2Warning:
            word = STATUS[status] if status < len(STATUS) else str(status)
            raise self.failure(f"the step failed ({word})")

    def text(self, name: str) -> str:
        """Return the value of a string variable.

        Parameters
        ----------
        name : str
            A string variable.
        """
        reference = int(self.variables[name].valueReference)
        values: list[bytes | None] = self._fmu.getString([reference])
        return (values[0] or b"").decode("utf-8", "replace")

    # What it says

    def failure(self, what: str) -> FmuError:
        """Return an error that reports what failed, when, and why.

        Parameters
        ----------
        what : str
            What failed, in words; the FMU's own last message follows it.
        """
        cause = self._cause() or "it gave no reason"
        return FmuError(f"{self.label} FMU at {self.time_s:g} s: {what}: {cause}")

    def _log(self, status: int, text: str) -> None:
        if status >= fmi2Warning and text.strip():
            self._messages.append(text.strip())
            if status == fmi2Warning:
                self._show(f"{self.label} FMU at {self.time_s:g} s, warning: {text.strip()}")

    def _cause(self) -> str:
        # The last line of a traceback names the error; the rest is for whoever fixes it.
        said = self._messages[-1:] or [self._printed.getvalue()]
        lines = [line.strip() for line in said[0].splitlines() if line.strip()]
        if not lines:
            return ""
        return lines[-1] if any(line.startswith("Traceback") for line in lines) else lines[0]

    def said(self) -> str:
        """Return all error messages of the FMU, including tracebacks."""
        return "\n".join(self._messages) or self._printed.getvalue().strip()


@contextlib.contextmanager
def alone(fmu: Path, label: str) -> Iterator[tuple[Slave, Callable[[], None]]]:
    """Give one FMU, and a check for Ctrl-C; what the FMU prints is kept for its errors.

    Parameters
    ----------
    fmu : Path
    label : str
        See `Slave`.

    Yields
    ------
    tuple of Slave and callable
        See `interruptible`.
    """
    printed, stderr = io.StringIO(), sys.stderr
    with contextlib.redirect_stderr(printed):
        slave = Slave(fmu, label, lambda line: print(line, file=stderr), printed)
        with slave, interruptible() as check:
            yield slave, check


@contextlib.contextmanager
def interruptible() -> Iterator[Callable[[], None]]:
    """Keep Ctrl-C and SIGTERM out of FMUs: give a function that raises if one of them came.

    A Python FMU in the same process would take the interruption for its own failure, and unpacked
    files would stay if SIGTERM ended the process at once.

    Returns
    -------
    callable
        Raises KeyboardInterrupt after Ctrl-C, and after SIGTERM SystemExit with a shell's exit code
        for a terminated program.
    """
    came: list[int] = []

    def check() -> None:
        if signal.SIGTERM in came:
            raise SystemExit(128 + signal.SIGTERM)
        if came:
            raise KeyboardInterrupt

    if threading.current_thread() is not threading.main_thread():
        yield check
        return
    with on_signals(("SIGINT", "SIGTERM"), lambda number, frame: came.append(number)):
        yield check
    check()
