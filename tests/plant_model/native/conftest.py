"""The plant's C core, compiled for any machine and called through ctypes."""

import ctypes
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

import numpy as np
import pytest

from fmu_packaging.native import compilers
from fmu_packaging.native.build import C_FOLDER
from fmu_packaging.native.compilers import STRICT, c_files, write_sources
from plant_model.fmi_slave import variables
from plant_model.machine import Machine
from plant_model.native.generate import machine_sources, program, tunable_of, variable_sources
from plant_model.parameters import FloatArray

HERE = Path(__file__).resolve().parent
NUMBERS = ctypes.POINTER(ctypes.c_double)


@pytest.fixture(scope="session", autouse=True)
def compiled_here(compiler: tuple[str, ...]) -> None:
    """Nothing of this room runs without a compiler."""


class Core:
    """One plant in C.

    Parameters
    ----------
    library : ctypes library
    machine : Machine
    values : dict of str to float
        Parameters that differ from the machine's.
    seed : int
        Of the noise; 0: none.
    """

    def __init__(
        self, library: ctypes.CDLL, machine: Machine, values: Mapping[str, float], seed: int = 0
    ) -> None:
        self._library, self._count = library, 0
        known = machine.parameters
        given = [values.get(name, known[name].value) for name in tunable_of(machine)]
        self._self = library.core_new(_numbers(given), seed)
        rig = 5 if machine.rig["kind"] == "five_point" else len(machine.rig["axes"])
        self._shown = np.zeros(len(machine.sensors) + rig + 9)

    def __del__(self) -> None:
        self._library.core_free(self._self)

    @property
    def linear(self) -> bool:
        return bool(self._library.core_is_linear(self._self))

    def start(self, inputs: Sequence[float], rises: Sequence[float], tool: float) -> None:
        self._library.core_start(self._self, _numbers(inputs), _numbers(rises), tool)

    def step(
        self, step_s: float, inputs: Sequence[float], tool: float, offsets: Sequence[float]
    ) -> str:
        """Return what is wrong, nothing if nothing is."""
        found = self._library.core_step(
            self._self, step_s, _numbers(inputs), tool, _numbers(offsets)
        )
        return "" if found is None else str(found.decode())

    def outputs(self) -> FloatArray:
        self._library.core_outputs(self._self, self._shown.ctypes.data_as(NUMBERS))
        return self._shown.copy()


def _numbers(values: Sequence[float]) -> ctypes.Array[ctypes.c_double]:
    return (ctypes.c_double * max(len(values), 1))(*values)


@pytest.fixture(scope="session")
def library_of(
    compiler: tuple[str, ...], tmp_path_factory: pytest.TempPathFactory
) -> Callable[[Machine], ctypes.CDLL]:
    """Compiles the core of a machine, of the same one once."""
    known: dict[str, ctypes.CDLL] = {}

    def library(machine: Machine) -> ctypes.CDLL:
        whole = repr(machine)
        if whole not in known:
            known[whole] = core_of(machine, compiler, tmp_path_factory.mktemp("core"))
        return known[whole]

    return library


def core_of(machine: Machine, compiler: Sequence[str], folder: Path) -> ctypes.CDLL:
    """Compile the core of a machine in a folder, and load it."""
    sources = {**program(), **machine_sources(machine)}
    for name in ("model.c", "forward.c", "backward.c"):  # only an FMU calls derivatives
        sources.pop(name, None)
    sources["model_data.c"] = variable_sources(variables(machine), "core", "{0}")
    sources["core.c"] = (HERE / "core.c").read_text()
    for name in ("model.h", "setup.h"):
        sources[name] = (C_FOLDER / name).read_text()
    write_sources(folder, sources)
    flags = ("-O0", "-fPIC", "-fvisibility=hidden", "-shared", "-o", "core.so")
    compilers.run_compiler([*compiler, *STRICT, *flags, *c_files(sources), "-lm"], folder)
    found = ctypes.CDLL(str(folder / "core.so"))
    found.core_new.restype = ctypes.c_void_p
    found.core_new.argtypes = [NUMBERS, ctypes.c_uint]
    found.core_free.argtypes = [ctypes.c_void_p]
    found.core_start.argtypes = [ctypes.c_void_p, NUMBERS, NUMBERS, ctypes.c_double]
    found.core_step.restype = ctypes.c_char_p
    found.core_step.argtypes = [ctypes.c_void_p, ctypes.c_double, NUMBERS, ctypes.c_double, NUMBERS]
    found.core_is_linear.argtypes = [ctypes.c_void_p]
    found.core_outputs.argtypes = [ctypes.c_void_p, NUMBERS]
    return found
