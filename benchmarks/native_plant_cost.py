"""What a step of the plant in C costs, against the plant in Python stepped the same way.

In C a program sets the inputs, steps and gets the outputs through FMI; in Python the stepper itself
is called, without an FMU around it. Both by the processor's clock, with a speed that stays and with
another speed in every step. The ratio is the median over turns that the two take.
``python -m benchmarks.native_plant_cost``
"""

from __future__ import annotations

import argparse
import statistics
import subprocess
import tempfile
import time
from collections.abc import Callable, Sequence
from pathlib import Path

import fmpy

import build_fmu
from fmu_packaging.native.build import HEADERS, native_package
from fmu_packaging.native.compilers import STRICT, compilers, run_compiler
from plant_model.machine_file import read_machine
from plant_model.native.build import native_plant
from plant_model.stepper import OFFSETS, PlantStepper

HOST = Path(__file__).resolve().parent / "plant_host.c"
MACHINES = ("jig_borer_lumps", "jig_borer")
TARGETS_US = {"the same speed": 3.0, "another speed": 60.0}
SPEEDS = {"the same speed": [6000.0], "another speed": [3000.0, 9000.0, 6000.0]}


def in_c(folder: Path, machine: str) -> Callable[[Sequence[float], int], float]:
    """Return what measures a step in a program in C [us]."""
    recipe, _ = build_fmu.plant_recipe(read_machine(machine), "plant_native")
    package = native_package(recipe, native_plant(recipe), compilers()[:1])
    path = folder / "plant.fmu"
    path.write_bytes(package.zipped())
    unpacked = Path(fmpy.extract(str(path), unzipdir=str(folder / "plant")))
    suffix = fmpy.sharedLibraryExtension
    library = unpacked / "binaries" / fmpy.platform / f"{package.name}{suffix}"
    command = [*compilers()[0].command, *STRICT, "-O2", f"-I{HEADERS}", "-o", "host", str(HOST)]
    run_compiler([*command, "-ldl"], folder)
    variables = package.slave.variables
    outputs = [place for place, variable in enumerate(variables) if variable.is_output]
    inputs = len(package.slave.inputs)

    def measure(speeds: Sequence[float], steps: int) -> float:
        numbers = (steps, inputs, outputs[0], len(outputs), *speeds)
        done = subprocess.run(
            [str(folder / "host"), str(library), package.guid, *map(str, numbers)],
            capture_output=True,
            text=True,
            check=True,
        )
        return float(done.stdout.split()[0]) / 1e3

    return measure


def in_python(machine: str) -> Callable[[Sequence[float], int], float]:
    """Return what measures a step of the stepper in Python [us]."""
    known = read_machine(machine)
    speed = known.inputs[0].name
    usual = {entry.name: 20.0 if entry.is_boundary else 0.0 for entry in known.inputs}
    usual |= {"tool_length": 150.0} | dict.fromkeys(OFFSETS, 0.0)

    def measure(speeds: Sequence[float], steps: int) -> float:
        plant = PlantStepper(known)
        begun = time.process_time()
        for k in range(steps):
            value = speeds[k % len(speeds)] + (1e-6 * k if len(speeds) > 1 else 0.0)
            plant.step(1.0, usual | {speed: value})
        return (time.process_time() - begun) / steps * 1e6

    return measure


def main() -> None:
    """Measure, and print a table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--turns", type=int, default=5)
    parser.add_argument("--steps", type=int, default=400, help="in Python; a hundred times in C")
    given = parser.parse_args()
    print(
        f"{'machine':16} {'a step at':16}"
        f" {'C [us]':>8} {'target':>8} {'Python [us]':>12} {'ratio':>7}"
    )
    for machine in MACHINES:
        with tempfile.TemporaryDirectory() as folder:
            native, python = in_c(Path(folder), machine), in_python(machine)
            for name, speeds in SPEEDS.items():
                pairs = [
                    (native(speeds, 100 * given.steps), python(speeds, given.steps))
                    for _ in range(given.turns)
                ]
                one, other = (statistics.median(column) for column in zip(*pairs, strict=True))
                ratio = statistics.median(slow / fast for fast, slow in pairs)
                print(
                    f"{machine:16} {name:16}"
                    f" {one:8.2f} {TARGETS_US[name]:8.0f} {other:12.1f} {ratio:7.0f}"
                )


if __name__ == "__main__":
    main()
