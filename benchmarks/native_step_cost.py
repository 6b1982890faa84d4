"""What a step of the C compensator costs, against a C FMU of the same variables that does nothing.

Both come from the same generator and compiler, and a program in C drives them in turn; from Python
`benchmarks.peers` does. The ratio is the median over the turns, because two runs side by side
suffer alike from other load.
``python -m benchmarks.native_step_cost``
"""

from __future__ import annotations

import argparse
import json
import statistics
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import fmpy

import build_fmu
from fmu_compensator.native.build import native_compensator
from fmu_packaging.native.build import HEADERS, native_package
from fmu_packaging.native.compilers import STRICT, compilers, run_compiler
from fmu_packaging.variables import Variable

HERE = Path(__file__).resolve().parent
EMPTY = HERE / "empty_compensator.c"
HOST = HERE / "native_host.c"


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


def step_us(host: Path, fmu: Fmu, steps: int) -> float:
    """Return what a step costs [us]."""
    numbers = (steps, len(fmu.inputs), fmu.tool, fmu.outputs.start, len(fmu.outputs))
    done = subprocess.run(
        [str(host), fmu.library, fmu.guid, *map(str, numbers)],
        capture_output=True,
        text=True,
        check=True,
    )
    return float(done.stdout.split()[0]) * 1e-3


def _host(folder: Path) -> Path:
    command = [*compilers()[0].command, *STRICT, "-O2", f"-I{HEADERS}"]
    run_compiler([*command, "-o", str(folder / "host"), str(HOST), "-ldl"], folder)
    return folder / "host"


def measure(steps: int, repeats: int, model: Path) -> dict[str, float]:
    """Return the cost of a step of each FMU [us] and their ratio.

    Parameters
    ----------
    steps : int
        Steps a run.
    repeats : int
        Runs of each; one more of each warms up and is not counted.
    model : Path
        Compensator file.
    """
    with tempfile.TemporaryDirectory(prefix="native_step_cost_") as name:
        fmus, host = _fmus(Path(name), model), _host(Path(name))
        turns = [
            {kind: step_us(host, fmu, steps) for kind, fmu in fmus.items()}
            for _ in range(repeats + 1)
        ][1:]
    return {
        "real_us": statistics.median(turn["real"] for turn in turns),
        "empty_us": statistics.median(turn["empty"] for turn in turns),
        "ratio": statistics.median(turn["real"] / turn["empty"] for turn in turns),
    }


def main() -> int:
    """Measure and print."""
    parser = argparse.ArgumentParser("benchmarks.native_step_cost", description=__doc__)
    parser.add_argument("--steps", type=int, default=2_000_000, help="steps a run (2000000)")
    parser.add_argument("--repeats", type=int, default=9, help="runs of each (9)")
    parser.add_argument("--model", type=Path, default=build_fmu.DEFAULT_MODEL)
    parser.add_argument("--json", action="store_true", help="print JSON")
    arguments = parser.parse_args()
    found = measure(arguments.steps, arguments.repeats, arguments.model)
    if arguments.json:
        print(json.dumps(found, indent=1))
    else:
        costs = f"compensator {found['real_us']:.3f}, empty FMU {found['empty_us']:.3f}"
        print(f"a step in C [us]: {costs}, ratio {found['ratio']:.2f}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
