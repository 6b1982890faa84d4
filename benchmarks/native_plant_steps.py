"""The time of each step of the plant in C, and the worst step compared with the median.

The speed is constant, then constant at another value, then different in every step. The time of a
step is the minimum over many runs. The empty FMU has the same variables, but its step does nothing.
Below the table it states which targets are met.
``python -m benchmarks.native_plant_steps``
"""

from __future__ import annotations

import statistics
import subprocess
import tempfile
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import fmpy

import build_fmu
from benchmarks.results_page import as_table, parser_of, tell
from fmu_packaging.native.build import HEADERS, native_package
from fmu_packaging.native.compilers import STRICT, compilers, run_compiler
from plant_model.effects import catalogue
from plant_model.machine import Machine
from plant_model.machine_file import read_machine
from plant_model.native.build import native_plant

HOST = Path(__file__).resolve().parent / "plant_steps.c"
EMPTY = Path(__file__).resolve().parent / "empty_plant.c"
STAYS, CHANGES = 20, 20
SPEEDS = [*[3000.0] * STAYS, *[9000.0] * STAYS, *(5000.0 + 137.0 * k for k in range(CHANGES))]
PROCESSES = 6
"""Number of processes that share the runs: the location of its memory can make a process up to 8 %
slower."""

STEPS_S = (0.001, 0.01, 0.1, 1.0, 10.0)
MOST_TIMES_MEDIAN = 3.0
"""Target for the worst step, as a multiple of the median, at any step length."""

MOST_TIMES_EMPTY = {"page of 95": 60.0, "24 lumps, 3 effects": 100.0}
"""Targets for a step with a changed speed, as a multiple of an empty step, at any step length."""

HEAD = (
    *("machine", "step", "speed stays [us]", "changes [us]", "worst [us]"),
    *("worst / median", "changes / empty"),
)
EFFECTS = ("natural_convection", "radiation", "viscosity_temperature")


def machines() -> dict[str, Machine]:
    """Return the machines to measure, by their names in the table."""
    lumps, page = read_machine("jig_borer_lumps"), read_machine("jig_borer")
    return {
        "24 lumps": lumps,
        "24 lumps, 3 effects": _with(lumps, EFFECTS),
        "page of 95": page,
        "page of 95, 3 effects": _with(page, EFFECTS),
    }


def _with(machine: Machine, names: Sequence[str]) -> Machine:
    added = {name: dict(catalogue()[name].parameters) for name in names}
    return replace(machine, effects=machine.effects | added)


@dataclass(frozen=True)
class Found:
    """Times of an FMU's steps [ns].

    Attributes
    ----------
    each : list of float
        Each step at SPEEDS, timed separately.
    held : float
        Mean of many steps timed together, at constant speed.
    """

    each: list[float]
    held: float

    @property
    def times_median(self) -> float:
        """The worst step as a multiple of the median."""
        return max(self.each) / statistics.median(self.each)


def measured(folder: Path, machine: Machine, empty: bool) -> Callable[[float, int], Found]:
    """Return a function that times a machine's FMU, given the step length and number of runs."""
    recipe, _ = build_fmu.plant_recipe(machine, "plant_native")
    native = native_plant(recipe)
    if empty:
        native = replace(native, program={**native.program, "plant.c": EMPTY.read_text("utf-8")})
    package = native_package(recipe, native, compilers()[:1])
    folder.mkdir()
    path = folder / "plant.fmu"
    path.write_bytes(package.zipped())
    unpacked = Path(fmpy.extract(str(path), unzipdir=str(folder / "plant")))
    name = f"{package.name}{fmpy.sharedLibraryExtension}"
    library = unpacked / "binaries" / fmpy.platform / name
    command = [*compilers()[0].command, *STRICT, "-O2", f"-I{HEADERS}", "-o", "host", str(HOST)]
    run_compiler([*command, "-ldl", "-lm"], folder)

    def measure(step_s: float, runs: int) -> Found:
        numbers = (-(-runs // PROCESSES), len(package.slave.inputs), step_s, *SPEEDS)
        command = [str(folder / "host"), str(library), package.guid, *map(str, numbers)]
        done = [
            subprocess.run(command, capture_output=True, text=True, check=True).stdout.split()
            for _ in range(PROCESSES)
        ]
        *each, held = (min(map(float, line)) for line in zip(*done, strict=True))
        return Found(each, held)

    return measure


def _verdict(what: str, ratios: Sequence[float], most: float) -> str:
    missed = [f"{s:g} s" for s, ratio in zip(STEPS_S, ratios, strict=True) if ratio > most]
    verdict = f"missed at {', '.join(missed)}" if missed else "met"
    return f"- {what}, at most {most:g}: {min(ratios):.1f} to {max(ratios):.1f}, {verdict}"


def main() -> None:
    """Measure, and print a table."""
    parser = parser_of(__doc__)
    parser.add_argument("--runs", type=int, default=300)
    given = parser.parse_args()
    rows = []
    worst: dict[str, list[float]] = {}
    empty: dict[str, list[float]] = {}
    with tempfile.TemporaryDirectory() as name:
        for number, (label, machine) in enumerate(machines().items()):
            real, nothing = (
                measured(Path(name) / f"{number}{kind}", machine, bool(kind)) for kind in (0, 1)
            )
            idle = nothing(STEPS_S[0], given.runs).held
            for step_s in STEPS_S:
                found = real(step_s, given.runs)
                stays = statistics.median(found.each[:-CHANGES])
                changes = statistics.median(found.each[-CHANGES:])
                worst.setdefault(label, []).append(found.times_median)
                empty.setdefault(label, []).append(changes / idle)
                costs = [f"{ns / 1e3:.2f}" for ns in (stays, changes, max(found.each))]
                ratios = [f"{found.times_median:.2f}", f"{changes / idle:.0f}"]
                rows.append([label, f"{step_s:g} s", *costs, *ratios])
    lines = [
        as_table(HEAD, rows),
        f"\nAn empty step takes {idle:.1f} ns. Targets, at any length of step:\n",
    ]
    lines += [
        _verdict(f"{label}, worst / median", ratios, MOST_TIMES_MEDIAN)
        for label, ratios in worst.items()
    ]
    lines += [
        _verdict(f"{label}, changes / empty", empty[label], most)
        for label, most in MOST_TIMES_EMPTY.items()
    ]
    tell("native_plant_steps", "\n".join(lines), write=given.write)


if __name__ == "__main__":
    main()
