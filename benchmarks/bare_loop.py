"""FMUs stepped over arrays that are made beforehand: what FMI calls cost, and nothing else.

Costs are times of the processor, in which other programs' turns do not count.
"""

from __future__ import annotations

import ctypes
import time
from collections.abc import Mapping
from contextlib import ExitStack
from pathlib import Path
from types import TracebackType
from typing import Any

import fmpy
import numpy as np
from fmpy.fmi2 import FMU2Slave

from scenarios.cosimulation import NOISE_SEED
from scenarios.scenario import Case, signal_setting

TYPES = {
    "Real": (np.float64, ctypes.c_double),
    "Integer": (np.int32, ctypes.c_int),
    "Boolean": (np.int32, ctypes.c_int),
}


class BareFmu:
    """An FMU, unpacked and initialised; use it in a ``with``.

    Attributes
    ----------
    names : dict of (causality, type) to list of str
    values : dict of (causality, type) to array
        The memory that the FMU reads or writes.
    """

    def __init__(
        self, path: Path, folder: Path, seed: int, start: Mapping[str, float] | None = None
    ) -> None:
        description = fmpy.read_model_description(str(path), validate=False)
        self._fmu: Any = FMU2Slave(
            guid=description.guid,
            unzipDirectory=fmpy.extract(str(path), unzipdir=str(folder)),
            modelIdentifier=description.coSimulation.modelIdentifier,
            instanceName=path.stem,
        )
        self._fmu.instantiate()
        self.names: dict[tuple[str, str], list[str]] = {}
        self.values: dict[tuple[str, str], Any] = {}
        self._calls: dict[tuple[str, str], tuple[Any, ...]] = {}
        for causality in ("input", "output"):
            for kind in TYPES:
                found = [
                    variable
                    for variable in description.modelVariables
                    if variable.causality == causality and variable.type == kind
                ]
                self._group((causality, kind), found)
        for variable in description.modelVariables:
            if variable.name == NOISE_SEED:
                self._fmu.setInteger([variable.valueReference], [seed])
        self._fmu.setupExperiment(startTime=0.0)
        self._fmu.enterInitializationMode()
        for place, name in enumerate(self.names["input", "Real"]):
            self.values["input", "Real"][place] = (start or {}).get(
                name, self.values["input", "Real"][place]
            )
        self._move(("input", "Real"))
        self._fmu.exitInitializationMode()
        for kind in TYPES:
            self._move(("output", kind))

    def _group(self, key: tuple[str, str], variables: list[Any]) -> None:
        number, element = TYPES[key[1]]
        count = len(variables)
        values = np.array([_start(entry.start) for entry in variables]).astype(number)
        refs = (ctypes.c_uint * count)(*(entry.valueReference for entry in variables))
        memory = (element * count).from_buffer(values.data) if count else None
        self.names[key], self.values[key] = [entry.name for entry in variables], values
        self._calls[key] = (self._fmu.component, refs, count, memory)

    def call(self, key: tuple[str, str]) -> tuple[Any, tuple[Any, ...]]:
        """Return the FMI function that moves a group of variables, and its arguments."""
        verb = "Set" if key[0] == "input" else "Get"
        return getattr(self._fmu, f"fmi2{verb}{key[1]}"), self._calls[key]

    def _move(self, key: tuple[str, str]) -> None:
        function, arguments = self.call(key)
        if arguments[2]:
            function(*arguments)

    @property
    def step(self) -> tuple[Any, Any]:
        """The function that steps, and the instance."""
        return self._fmu.fmi2DoStep, self._fmu.component

    def __enter__(self) -> BareFmu:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self._fmu.terminate()
        self._fmu.freeInstance()


def alone(path: Path, folder: Path, steps: int, changing: str) -> float:
    """Return what a step of one FMU costs: real inputs set, the step, real outputs got [us].

    *changing* is the input that is another in every step; the others stay.
    """
    with BareFmu(path, folder, seed=1) as fmu:
        given = fmu.values["input", "Real"]
        place = fmu.names["input", "Real"].index(changing)
        to_set, inputs = fmu.call(("input", "Real"))
        get, outputs = fmu.call(("output", "Real"))
        step, component = fmu.step
        begun = time.process_time()
        for k in range(steps):
            given[place] = 21.0 + 1e-6 * k
            to_set(*inputs)
            step(component, float(k), 1.0, 1)
            get(*outputs)
        return (time.process_time() - begun) / steps * 1e6


def coupled(case: Case, plant_fmu: Path, compensator_fmu: Path, folder: Path) -> float:
    """Return what a step of `scenarios.cosimulation` would cost if it kept nothing [us].

    The same calls in the same order with the same values; no table, no event, no fault, no look at
    the progress.
    """
    seed = max(case.settings.seed, 1)
    steps, step_s = case.settings.steps, case.settings.step_s
    moments = np.arange(steps) * step_s
    signals = {
        name: signal.values(moments, signal_setting(case.setting, name))
        for name, signal in case.signals.items()
    }
    first = {name: float(values[0]) for name, values in signals.items()}
    with ExitStack() as stack:
        plant = stack.enter_context(BareFmu(plant_fmu, folder / "plant", seed, first))
        # What the compensator sees first is what the plant shows first, or it sees a jump.
        first |= dict(
            zip(plant.names["output", "Real"], plant.values["output", "Real"], strict=True)
        )
        compensator = stack.enter_context(
            BareFmu(compensator_fmu, folder / "compensator", seed, first)
        )
        real_in, real_out = ("input", "Real"), ("output", "Real")
        given, seen = plant.names[real_in], compensator.names[real_in]
        shown, sent = plant.names[real_out], compensator.names[real_out]
        driven = [name for name in given if name in signals]
        told = [name for name in seen if name in signals]
        plant_rows = np.stack([signals[name] for name in driven], axis=1)
        told_rows = np.stack([signals[name] for name in told], axis=1)
        moved = [name for name in given if name in sent]
        measured = [name for name in seen if name in shown]
        to_plant, to_moved = _places(given, driven), _places(given, moved)
        to_told, to_measured = _places(seen, told), _places(seen, measured)
        take, give = _places(shown, measured), _places(sent, moved)
        calls = [plant.call(real_in), compensator.call(real_in)]
        plant_step, compensator_step = plant.step, compensator.step
        gets = [plant.call(real_out)]
        gets += [compensator.call(("output", kind)) for kind in TYPES]
        plant_in, plant_out = plant.values[real_in], plant.values[real_out]
        seen_in, sent_out = compensator.values[real_in], compensator.values[real_out]
        begun = time.process_time()
        for k in range(steps):
            plant_in[to_plant] = plant_rows[k]
            plant_in[to_moved] = sent_out[give]
            seen_in[to_measured] = plant_out[take]
            seen_in[to_told] = told_rows[k]
            for function, arguments in calls:
                function(*arguments)
            now = float(moments[k])
            compensator_step[0](compensator_step[1], now, step_s, 1)
            plant_step[0](plant_step[1], now, step_s, 1)
            for function, arguments in gets:
                function(*arguments)
        return (time.process_time() - begun) / steps * 1e6


def _start(text: str | None) -> float:
    """Return a start value; a boolean one is a word."""
    if text in ("true", "false"):
        return float(text == "true")
    return float(text or 0.0)


def _places(names: list[str], wanted: list[str]) -> Any:
    return np.array([names.index(name) for name in wanted], dtype=np.intp)
