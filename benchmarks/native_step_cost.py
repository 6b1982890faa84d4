"""What a step of the C compensator costs, against a C FMU of the same variables that does nothing.

Both come from the same generator and compiler. Two masters take turns with them: a Python loop over
the FMI functions with arrays made beforehand, and a program in C. The ratio is the median over the
turns, because two runs side by side suffer alike from other load.
``python -m benchmarks.native_step_cost``
"""

from __future__ import annotations

import argparse
import ctypes
import json
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import fmpy
from fmpy.fmi2 import FMU2Slave, fmi2ValueReference

import build_fmu
from fmu_compensator.native.build import native_compensator
from fmu_packaging.native.build import HEADERS, native_package
from fmu_packaging.native.compilers import STRICT, compilers, run_compiler
from fmu_packaging.variables import Variable

HERE = Path(__file__).resolve().parent
EMPTY = HERE / "empty_compensator.c"
HOST = HERE / "native_host.c"
C_FACTOR = 100  # steps of the program in C for each of the loop in Python


@dataclass(frozen=True)
class Fmu:
    """One of the two FMUs, unpacked, with the value references of its real variables."""

    folder: str
    guid: str
    name: str
    inputs: range
    outputs: range
    tool: int

    @property
    def library(self) -> str:
        """The binary for this machine."""
        suffix = fmpy.sharedLibraryExtension
        return str(Path(self.folder) / "binaries" / fmpy.platform / f"{self.name}{suffix}")


def _fmus(folder: Path, model: Path) -> dict[str, Fmu]:
    recipe, _ = build_fmu.compensator_recipe(model, "compensator_native", native=True)
    found = {}
    for kind, exchanged in (("real", {}), ("empty", {"compensator.c": EMPTY.read_text("utf-8")})):
        package = native_package(recipe, native_compensator(recipe, exchanged), compilers()[:1])
        path = folder / f"{kind}.fmu"
        path.write_bytes(package.zipped())
        unpacked = fmpy.extract(str(path), unzipdir=str(folder / kind))
        slave = package.slave
        places = [_reals(slave.variables, causality) for causality in ("input", "output")]
        tool = slave.refs["tool_length"]
        found[kind] = Fmu(unpacked, package.guid, package.name, *places, tool)
    return found


def _reals(variables: Sequence[Variable], causality: str) -> range:
    """Return the value references of the real variables of a causality, which are consecutive."""
    found = [
        reference
        for reference, variable in enumerate(variables)
        if variable.kind == "real" and variable.causality == causality
    ]
    return range(found[0], found[-1] + 1)


def in_python(fmu: Fmu, steps: int) -> float:
    """Return what a step costs in a loop over the FMI functions [us]."""
    slave = FMU2Slave(
        guid=fmu.guid, unzipDirectory=fmu.folder, modelIdentifier=fmu.name, instanceName="one"
    )
    slave.instantiate()
    slave.setupExperiment(startTime=0.0)
    slave.enterInitializationMode()
    slave.exitInitializationMode()
    inputs, outputs = len(fmu.inputs), len(fmu.outputs)
    refs = [(fmi2ValueReference * len(one))(*one) for one in (fmu.inputs, fmu.outputs)]
    given, taken = (ctypes.c_double * inputs)(), (ctypes.c_double * outputs)()
    given[:] = [20.0] * inputs
    given[fmu.tool] = 100.0
    begun = time.perf_counter()
    for k in range(steps):
        given[0] = 20.0 + 1e-6 * k
        slave.fmi2SetReal(slave.component, refs[0], inputs, given)
        slave.fmi2DoStep(slave.component, float(k), 1.0, 1)
        slave.fmi2GetReal(slave.component, refs[1], outputs, taken)
    spent = time.perf_counter() - begun
    slave.terminate()
    slave.freeInstance()
    return spent / steps * 1e6


def in_c(host: Path) -> Callable[[Fmu, int], float]:
    """Return what measures a step in a program in C [us]."""

    def measure(fmu: Fmu, steps: int) -> float:
        numbers = (steps * C_FACTOR, len(fmu.inputs), fmu.tool, fmu.outputs.start, len(fmu.outputs))
        done = subprocess.run(
            [str(host), fmu.library, fmu.guid, *map(str, numbers)],
            capture_output=True,
            text=True,
            check=True,
        )
        return float(done.stdout.split()[0]) * 1e-3

    return measure


def _host(folder: Path) -> Path:
    command = [*compilers()[0].command, *STRICT, "-O2", f"-I{HEADERS}"]
    run_compiler([*command, "-o", str(folder / "host"), str(HOST), "-ldl"], folder)
    return folder / "host"


def measure(steps: int, repeats: int, model: Path) -> dict[str, dict[str, float]]:
    """Return for each master the cost of a step of each FMU [us] and their ratio.

    Parameters
    ----------
    steps : int
        Steps a run in Python; the program in C makes a hundred times as many.
    repeats : int
        Runs of each; one more of each warms up and is not counted.
    model : Path
        Compensator file.
    """
    found = {}
    with tempfile.TemporaryDirectory(prefix="native_step_cost_") as name:
        folder = Path(name)
        fmus = _fmus(folder, model)
        for master, run in (("python", in_python), ("c", in_c(_host(folder)))):
            turns = [
                {kind: run(fmu, steps) for kind, fmu in fmus.items()} for _ in range(repeats + 1)
            ][1:]
            found[master] = {
                "real_us": statistics.median(turn["real"] for turn in turns),
                "empty_us": statistics.median(turn["empty"] for turn in turns),
                "ratio": statistics.median(turn["real"] / turn["empty"] for turn in turns),
            }
    return found


def main() -> int:
    """Measure and print."""
    parser = argparse.ArgumentParser("benchmarks.native_step_cost", description=__doc__)
    parser.add_argument("--steps", type=int, default=20000, help="steps a run in Python (20000)")
    parser.add_argument("--repeats", type=int, default=9, help="runs of each (9)")
    parser.add_argument("--model", type=Path, default=build_fmu.DEFAULT_MODEL)
    parser.add_argument("--json", action="store_true", help="print JSON")
    arguments = parser.parse_args()
    found = measure(arguments.steps, arguments.repeats, arguments.model)
    if arguments.json:
        print(json.dumps(found, indent=1))
        return 0
    print("a step [us]               C compensator   empty C FMU   ratio")
    for master, title in (("python", "loop in Python, ctypes"), ("c", "loop in C")):
        row = found[master]
        costs = f"{row['real_us']:13.3f} {row['empty_us']:13.3f} {row['ratio']:7.2f}"
        print(f"{title:<26}{costs}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
