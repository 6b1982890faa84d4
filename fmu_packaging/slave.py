"""Base class of this project's FMUs: declared variables, flat storage, full states, messages.

Facts about pythonfmu's binary that shape this module:

- every call costs one Python call, so values are in dicts by value reference and the four getters
  and setters are overridden;
- an exception that reaches the binary becomes ``fmi2Fatal``, the only failure status it can return
  outside a step. It then releases references to the instance, its class and its log queue, and does
  so again when the instance is freed, so `_fail` adds one reference to each;
- a message is a format string for the host's logger, so a percent sign is doubled;
- with logging off it drops every message, so the cause of an error also goes to standard error;
- when the process ends it releases its static state twice, which occasionally aborts a process that
  had finished its work, so `closing` releases it once before.
"""

from __future__ import annotations

import ctypes
import hashlib
import json
import math
import sys
import traceback
from abc import abstractmethod
from collections.abc import Sequence
from enum import IntEnum
from pathlib import Path
from typing import Any, ClassVar, NoReturn

from pythonfmu.enums import Fmi2Status
from pythonfmu.fmi2slave import Fmi2Slave

from fmu_packaging.closing import close_in_order
from fmu_packaging.variables import ZERO, Value, Variable

STATE_FORMAT = 3
"""Format of an FMU state: given by what `DriftSlave` stores in it."""

SAME_TIME = 2.0**-23
"""Relative difference up to which two clocks agree, but at most half a step, so that it cannot be
another step: given by a host's clock in single precision."""

KINDS = ("real", "integer", "boolean", "string")
_resources: dict[tuple[str, str], str] = {}


class Phase(IntEnum):
    """Phases in the life of an instance."""

    INSTANTIATED = 0
    INITIALISING = 1
    STEPPING = 2
    TERMINATED = 3


class FmuError(ValueError):
    """Something the FMU cannot do; the text says what and why in one line."""

    def __repr__(self) -> str:
        """Return only the text, because the binary logs an exception's representation."""
        return str(self)


class DriftSlave(Fmi2Slave):
    """An FMU whose variables are declared as data.

    A subclass defines its variables (`declare`), how it starts (`begin`) and advances (`advance`),
    and its remaining state (`hidden`, `restore`). In these hooks it reads inputs and parameters
    from `inputs` and `parameters` and sets outputs with `put`.

    Parameters
    ----------
    **kwargs
        Arguments from pythonfmu's binary: ``instance_name``, ``resources`` (a folder) and more.

    Attributes
    ----------
    variables : list of Variable
        In the order of their value references.
    refs : dict of str to int
        Value reference of each variable.
    inputs : dict of int to float
        The real inputs by value reference, in the order declared.
    outputs : dict of int to float
        The real outputs by value reference.
    settable, results : dict of str to dict
        The same for every kind: `settable` has the inputs, `results` the outputs.
    parameters : dict of str to value
        Parameters by name.
    time_s : float
        Current time [s].
    clock_may_jump : bool
        Whether a step need not begin at the end of the previous one.
    enumerations : dict of str to dict of int to str
        Meanings of an integer variable's codes, by the variable's name with a capital letter.

    Notes
    -----
    The methods with names of FMI 2.0 (`setup_experiment`, `do_step`, `get_real` ...) are called by
    the binary. A refusal there raises `FmuError`, which the host sees as a failure.
    """

    clock_may_jump: ClassVar[bool] = False
    enumerations: ClassVar[dict[str, dict[int, str]]] = {}
    log_categories: ClassVar[dict[str, str]] = {
        "logStatusError": "Calls that were refused and steps that were not made"
    }

    def __init__(self, **kwargs: Any) -> None:
        super().__init__(**kwargs)
        self.folder = Path(self.resources) if self.resources else Path()
        close_in_order(self.folder)
        self.variables: list[Variable] = list(self.declare())
        self.refs = {variable.name: ref for ref, variable in enumerate(self.variables)}
        self.parameters: dict[str, Value] = {}
        self.settable: dict[str, dict[int, Any]] = {kind: {} for kind in KINDS}
        self.results: dict[str, dict[int, Any]] = {kind: {} for kind in KINDS}
        for ref, variable in enumerate(self.variables):
            if variable.is_parameter:
                self.parameters[variable.name] = _start(variable)
            elif not variable.is_output:
                self.settable[variable.kind][ref] = _start(variable)
        self.inputs: dict[int, float] = self.settable["real"]
        self.outputs: dict[int, float] = self.results["real"]
        self.time_s, self._stop_s = 0.0, math.inf
        self._phase = Phase.INSTANTIATED
        self._broken = ""

    # Hooks of a subclass

    @abstractmethod
    def declare(self) -> Sequence[Variable]:
        """Return the variables."""

    def prepare(self) -> None:
        """Prepare whatever depends on the current parameters, before `begin` or `restore`.

        Raises
        ------
        FmuError
            For a parameter that cannot be used.
        """

    @abstractmethod
    def begin(self) -> None:
        """Start from the current inputs and parameters and set all outputs.

        Raises
        ------
        FmuError
            For an input that cannot be used.
        """

    @abstractmethod
    def advance(self, time_s: float, step_s: float) -> None:
        """Advance from *time_s* by *step_s* [s] with constant inputs and set all outputs.

        Parameters
        ----------
        time_s : float
            Start of the step [s].
        step_s : float
            Length of the step, above 0 [s].
        """

    def hidden(self) -> dict[str, Any]:
        """Return the state outside the variables, ready for JSON; not shared with later states."""
        return {}

    def restore(self, state: dict[str, Any]) -> None:
        """Restore what `hidden` returned; `prepare` has run with the same parameters.

        Parameters
        ----------
        state : dict
            Plain values, as returned by `hidden`.
        """

    def resource(self, name: str) -> str:
        """Return the text of a file in the FMU's resources.

        It is read only once: a reset makes a new instance and must not fail for a missing file.

        Parameters
        ----------
        name : str
            The file's path in the resources folder.
        """
        key = (str(self.folder), name)
        if key not in _resources:
            _resources[key] = (self.folder / name).read_text(encoding="utf-8")
        return _resources[key]

    def put(self, name: str, value: Value) -> None:
        """Set one output.

        Parameters
        ----------
        name : str
            A declared output.
        value : float, int, bool or str
            Of the variable's kind, in its unit.
        """
        ref = self.refs[name]
        self.results[self.variables[ref].kind][ref] = value

    # Life of an instance

    def setup_experiment(
        self, start_time: float, stop_time: float | None = None, tolerance: float | None = None
    ) -> None:
        """Store the start time and the stop time [s]."""
        if self._phase is not Phase.INSTANTIATED:
            self._fail("the experiment must be set up before the initialisation")
        stop_s = math.inf if stop_time is None else stop_time
        if not math.isfinite(start_time) or not start_time <= stop_s:
            self._fail("the experiment must begin at a finite time and not stop before it begins")
        self.time_s, self._stop_s = start_time, stop_s

    def terminate(self) -> None:
        """End the simulation; no step may follow."""
        if self._phase is not Phase.STEPPING:
            self._fail("there is no simulation to be terminated")
        self._phase = Phase.TERMINATED

    def enter_initialization_mode(self) -> None:
        """Begin the initialisation."""
        if self._phase is not Phase.INSTANTIATED:
            self._fail("the initialisation has begun already: reset first")
        self._phase = Phase.INITIALISING

    def exit_initialization_mode(self) -> None:
        """Check the parameters and start; a failure is logged with its cause and is an error."""
        if self._phase is not Phase.INITIALISING:
            self._fail("the initialisation has not begun, or has ended")
        if not self._started():
            self._fail(self._broken)
        self._phase = Phase.STEPPING

    def do_step(self, current_time: float, step_size: float) -> bool:
        """Advance by a step; a failure is logged with its traceback and the step is discarded."""
        try:
            self._may_step(current_time, step_size)
            self.advance(current_time, step_size)
        except Exception as error:
            cause = traceback.format_exc() if not isinstance(error, FmuError) else str(error)
            self.report(f"the step at {current_time:g} s failed: {cause}")
            return False
        self.time_s = current_time + step_size
        return True

    def slack(self, step_s: float) -> float:
        """Return the tolerance for a host's clock in a step of this length [s]."""
        return min(SAME_TIME * (abs(self.time_s) + 1.0), step_s / 2.0)

    def _may_step(self, time_s: float, step_s: float) -> None:
        """Refuse an impossible step."""
        slack = self.slack(step_s)
        if self._phase is Phase.TERMINATED:
            raise FmuError("a step after the end of the simulation")
        if self._phase is not Phase.STEPPING:
            raise FmuError(self._broken or "a step before the end of the initialisation")
        if not math.isfinite(time_s):
            raise FmuError("the step does not begin at a finite time")
        if not (step_s > 0.0 and math.isfinite(time_s + step_s)):
            raise FmuError(f"a step of {step_s:g} s: it must be above 0 and finite")
        if not self.clock_may_jump and not abs(time_s - self.time_s) <= slack:
            raise FmuError(f"the step does not begin at {self.time_s:g} s, the time reached")
        if time_s + step_s > self._stop_s + slack:
            raise FmuError(f"the step goes beyond {self._stop_s:g} s, the stop time")

    def _started(self) -> bool:
        """Run `begin` unless it has run for the current values; return whether it succeeded."""
        if any(self.results.values()):
            return True
        try:
            for name, value in self.parameters.items():
                refusal = self.variables[self.refs[name]].refusal(value)
                if refusal:
                    raise FmuError(refusal)
            self.prepare()
            self.begin()
        except Exception as error:
            for results in self.results.values():
                results.clear()
            self._broken = str(error) if isinstance(error, FmuError) else traceback.format_exc()
            return False
        self._broken = ""
        return True

    # Values

    def get_real(self, vrs: list[int]) -> list[float]:
        """Return real variables by value reference."""
        try:
            return list(map(self.outputs.__getitem__, vrs))
        except KeyError:
            return self._looked_up("real", vrs)

    def get_integer(self, vrs: list[int]) -> list[int]:
        """Return integer variables by value reference."""
        return self._get("integer", vrs)

    def get_boolean(self, vrs: list[int]) -> list[bool]:
        """Return boolean variables by value reference."""
        return self._get("boolean", vrs)

    def get_string(self, vrs: list[int]) -> list[str]:
        """Return string variables by value reference."""
        return self._get("string", vrs)

    def set_real(self, vrs: list[int], values: list[float]) -> None:
        """Set real inputs and parameters by value reference."""
        inputs = self.inputs
        if self._phase is Phase.STEPPING and all(map(inputs.__contains__, vrs)):
            inputs.update(zip(vrs, values, strict=False))
        else:
            self._set("real", vrs, values)

    def set_integer(self, vrs: list[int], values: list[int]) -> None:
        """Set integer inputs and parameters by value reference."""
        self._set("integer", vrs, values)

    def set_boolean(self, vrs: list[int], values: list[bool]) -> None:
        """Set boolean inputs and parameters by value reference."""
        self._set("boolean", vrs, values)

    def set_string(self, vrs: list[int], values: list[str]) -> None:
        """Set string inputs and parameters by value reference."""
        self._set("string", vrs, values)

    def _get(self, kind: str, vrs: list[int]) -> list[Any]:
        try:
            return list(map(self.results[kind].__getitem__, vrs))
        except KeyError:
            return self._looked_up(kind, vrs)

    def _looked_up(self, kind: str, vrs: list[int]) -> list[Any]:
        """Return values of any causality; before the start, outputs are computed on demand."""
        for ref in vrs:
            self._known(kind, ref, "read")
        if any(self.variables[ref].is_output for ref in vrs) and not self._started():
            self.report(self._broken)
        return [self._value(kind, ref) for ref in vrs]

    def _value(self, kind: str, ref: int) -> Any:
        variable = self.variables[ref]
        if variable.is_parameter:
            return self.parameters[variable.name]
        if variable.is_output:
            return self.results[kind].get(ref, float("nan") if kind == "real" else ZERO[kind])
        return self.settable[kind][ref]

    def _set(self, kind: str, vrs: list[int], values: list[Any]) -> None:
        """Set variables of one kind, either all or none."""
        for ref in vrs:
            variable = self._known(kind, ref, "set")
            if variable.is_output:
                self._fail(f"{variable.name} cannot be set: it is an output")
            if self._phase is Phase.TERMINATED:
                self._fail(f"{variable.name} cannot be set after the end of the simulation")
            fixed = variable.is_parameter and variable.variability != "tunable"
            if fixed and self._phase is Phase.STEPPING:
                self._fail(f"{variable.name} cannot be set after the start")
        for ref, value in zip(vrs, values, strict=False):
            variable = self.variables[ref]
            if variable.is_parameter:
                self.parameters[variable.name] = value
            else:
                self.settable[kind][ref] = value
        if self._phase < Phase.STEPPING:
            for results in self.results.values():
                results.clear()

    def _known(self, kind: str, ref: int, verb: str) -> Variable:
        """Return the variable with a kind and value reference, or fail."""
        if not 0 <= ref < len(self.variables) or self.variables[ref].kind != kind:
            self._fail(f"value reference {ref} cannot be {verb}: it is no {kind} variable")
        return self.variables[ref]

    # State

    def _get_fmu_state(self) -> dict[str, Any]:
        """Return everything needed to continue a trajectory."""
        try:
            begun = self._phase >= Phase.STEPPING or self._started()
            hidden = json.dumps(self.hidden()) if begun else None
        except Exception:
            self._fail(f"the FMU state cannot be had: {traceback.format_exc()}")
        return {
            "format": STATE_FORMAT,
            "model": f"{type(self).__module__}.{type(self).__name__}",
            "time_s": self.time_s,
            "stop_s": self._stop_s,
            "phase": self._phase,
            "parameters": dict(self.parameters),
            "settable": {kind: list(values.values()) for kind, values in self.settable.items()},
            "results": {kind: list(values.items()) for kind, values in self.results.items()},
            "hidden": hidden,
        }

    def _set_fmu_state(self, state: dict[str, Any]) -> None:
        """Restore from `_get_fmu_state`; a damaged or foreign state is refused without changes."""
        problem = self._state_problem(state)
        if problem:
            self._fail(f"the FMU state cannot be used: {problem}")
        try:
            begun = state["hidden"] is not None
            if self._phase < Phase.STEPPING or state["parameters"] != self.parameters:
                self.parameters = dict(state["parameters"])
                if begun:
                    self.prepare()
            if begun:
                self.restore(json.loads(state["hidden"]))
        except Exception:
            self._fail(f"the FMU state cannot be used: {traceback.format_exc()}")
        for kind in KINDS:
            store = self.settable[kind]
            store.update(zip(list(store), state["settable"][kind], strict=True))
            results = self.results[kind]
            results.clear()
            results.update((int(ref), value) for ref, value in state["results"][kind])
        self.time_s, self._stop_s = state["time_s"], state["stop_s"]
        self._phase = Phase(state["phase"])

    def _state_problem(self, state: dict[str, Any]) -> str:
        if "problem" in state:
            return str(state["problem"])
        own = f"{type(self).__module__}.{type(self).__name__}"
        if state["format"] != STATE_FORMAT or state["model"] != own:
            return f"it belongs to {state['model']}, format {state['format']}"
        return ""

    @staticmethod
    def _fmu_state_to_bytes(state: dict[str, Any]) -> bytes:
        """Return a state as bytes, starting with a digest; the same state gives the same bytes."""
        body = json.dumps(state).encode()
        return hashlib.sha256(body).digest() + body

    @staticmethod
    def _fmu_state_from_bytes(state: bytes) -> dict[str, Any]:
        """Return a state from bytes; damaged bytes are refused when the state is set.

        It must not raise: without an instance, the binary cannot be protected from an exception.
        """
        digest, body = state[:32], state[32:]
        if hashlib.sha256(body).digest() != digest:
            return {"problem": "its bytes are damaged"}
        try:
            table = json.loads(body)
        except ValueError:
            table = None
        return table if isinstance(table, dict) and "model" in table else {"problem": "it is none"}

    # Messages

    def report(self, problem: str, status: Fmi2Status = Fmi2Status.error) -> None:
        """Log a problem, and write it to standard error for hosts with logging off.

        Parameters
        ----------
        problem : str
            What happened; may have several lines.
        status : Fmi2Status
            Its severity for the host.
        """
        self.log(problem.strip().replace("%", "%%"), status)
        if sys.stderr is not None:
            print(f"{self.instance_name}: {problem.strip()}", file=sys.stderr, flush=True)

    def _fail(self, problem: str) -> NoReturn:
        """Refuse a call: the host gets a failure status, and the cause in its log."""
        pending = [entry.msg for entry in self.log_queue]
        # The binary would log these while the exception is set, and so lose them.
        self.log_queue.clear()
        if sys.stderr is not None:
            print(f"{self.instance_name}: {problem.strip()}", file=sys.stderr, flush=True)
        for shared in (self, type(self), self.log_queue):
            ctypes.pythonapi.Py_IncRef(ctypes.py_object(shared))
        raise FmuError("\n".join([*pending, problem.strip().replace("%", "%%")]))


def _start(variable: Variable) -> Value:
    """Return a start value of the type expected by the binary."""
    start = ZERO[variable.kind] if variable.start is None else variable.start
    return float(start) if variable.kind == "real" else start
