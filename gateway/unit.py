"""An FMU at one end of the bus, with values in and out by name and its state as bytes."""

from __future__ import annotations

import contextlib
import io
from collections.abc import Callable, Iterator, Mapping
from math import nan
from pathlib import Path

from fmpy.fmi1 import FMICallException

from gateway.mapcheck import limits_of
from gateway.state import Saved, StateFile
from measurement.errors import BadInput
from scenarios.fmu import Port, Slave
from scenarios.probe_cycle import ProbeInputs
from scenarios.wiring import PROBED


class StatefulSlave(Slave):
    """An FMU whose state can be saved and restored."""

    @property
    def can_save(self) -> bool:
        """Whether the FMU declares that its state can be serialised."""
        return bool(self.description.coSimulation.canSerializeFMUstate)

    def kept(
        self, path: Path | None, say: Callable[[str], None], speed_up: float = 1.0
    ) -> tuple[StateFile | None, Saved | None]:
        """Return the file for the FMU's state and the state to continue from; None for either.

        Parameters
        ----------
        path : Path or None
            The file; None: the state is not kept.
        say : callable
            Takes a line for people: why a state is not used.
        speed_up : float, optional
            Seconds of the FMU per second of the time of day.

        Raises
        ------
        BadInput
            If the FMU has no state, or the file is not a state file.
        """
        if path is None:
            return None, None
        if not self.can_save:
            raise BadInput(self.path, "", "cannot save its state: run without --state")
        store = StateFile(path, self.sha256)
        saved, why_not = store.read(speed_up)
        if saved is None:
            say(f"{path}: the state is not used: {why_not}")
        return store, saved

    def saved(self) -> bytes:
        """Return the state of the FMU.

        Raises
        ------
        FmuError
            If the FMU does not return it.
        """
        with self._asked("it does not give its state"):
            state = self._fmu.getFMUstate()
        try:
            with self._asked("its state cannot be serialised"):
                return bytes(self._fmu.serializeFMUstate(state))
        finally:
            self._fmu.freeFMUstate(state)

    def restore(self, data: bytes) -> None:
        """Restore a state from `saved`.

        Raises
        ------
        FmuError
            If the FMU rejects it.
        """
        with self._asked("it does not accept a saved state"):
            state = self._fmu.deSerializeFMUstate(data)
            try:
                self._fmu.setFMUstate(state)
            finally:
                self._fmu.freeFMUstate(state)

    @contextlib.contextmanager
    def _asked(self, problem: str) -> Iterator[None]:
        try:
            yield
        except FMICallException:
            raise self.failure(problem) from None


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
        The real inputs of the FMU, except those for a probe.
    probed : list of str
        Those for a probe, except the flag.
    outputs : dict of str to float
        Every output except texts, by name; ``valid`` and the status are numbers.
    time_s : float
        The FMU's time [s].
    share : float
        The share of the predicted drift that is sent [1].
    """

    def __init__(
        self,
        path: Path,
        show: Callable[[str], None] = lambda line: None,
        printed: io.StringIO | None = None,
    ) -> None:
        self.slave = StatefulSlave(path, "compensator", show, printed or io.StringIO())
        self.share = limits_of(path).get("share", 1.0)
        named = self.slave.names("input")
        self.inputs = [name for name in named if not name.startswith(PROBED)]
        self._in = Port(self.slave, self.inputs)
        self._probe = ProbeInputs(self.slave)
        self.probed = self._probe.names
        kinds = ("Real", "Integer", "Boolean")
        self._ports = [Port(self.slave, self.slave.names("output", k), k) for k in kinds]
        self._texts = self.slave.names("output", "String")
        self._new: bytes | None = None
        self.time_s = 0.0
        self.outputs: dict[str, float] = {}

    @property
    def output_names(self) -> list[str]:
        """The names in `outputs` after the start."""
        return [name for port in self._ports for name in port.names]

    def start(self, saved: Saved | None = None) -> None:
        """Initialise the FMU, and continue from a saved state if there is one.

        Parameters
        ----------
        saved : Saved, optional
            State and time of an earlier run of the same FMU.

        Raises
        ------
        FmuError
            If the FMU fails.
        """
        with self.slave.starting(1e9):
            pass
        self._new = self.slave.saved() if self.slave.can_save else None
        if saved is not None:
            self.slave.restore(saved.state)
            self.time_s = saved.time_s
        self._read()

    def renew(self) -> None:
        """Forget everything, so that the next sample is the first.

        Raises
        ------
        FmuError
            If the FMU cannot return to its initial state.
        """
        if self._new is None:
            raise self.slave.failure("it cannot take up an earlier state")
        self.slave.restore(self._new)
        self.time_s = 0.0
        self._read()

    def step(self, values: Mapping[str, float], step_s: float) -> dict[str, float]:
        """Take one sample, in which NaN means missing, and advance by *step_s* [s].

        A probe is used if *values* holds all of its inputs.

        Parameters
        ----------
        values : mapping of str to float
            By input, each in its unit; absent inputs are missing.
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
        shown = [values[name] for name in self.probed if name in values]
        self._probe.set(shown if shown and len(shown) == len(self.probed) else None)
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
        """Return the unit of a variable; empty if it has none, or there is no such variable."""
        variable = self.slave.variables.get(name)
        return str(variable.unit or "") if variable is not None else ""

    def close(self, error: BaseException | None = None) -> None:
        """Release the FMU.

        Parameters
        ----------
        error : BaseException, optional
            The error that ended the gateway.
        """
        self.slave.__exit__(type(error) if error else None, error, None)
