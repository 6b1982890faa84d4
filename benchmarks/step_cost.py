"""What a co-simulated step costs, as ratios against named baselines of the same run.

Each FMU alone, against two FMUs of the same variables whose step is empty: one on this project's
base class, and one as pythonfmu alone would have it; and the scenario's loop over both FMUs. All
take turns, and a ratio is the median over the turns: runs that lie side by side suffer alike from
other load. Times are the processor's.
``python -m benchmarks.step_cost``
"""

from __future__ import annotations

import argparse
import ctypes
import json
import statistics
import sys
import tempfile
import time
import warnings
from collections.abc import Callable, Sequence
from dataclasses import asdict, replace
from functools import partial
from pathlib import Path
from typing import Any
from unittest.mock import patch

import fmpy
import numpy as np
from fmpy.fmi2 import FMU2Slave
from pythonfmu.builder import FmuBuilder

import build_fmu
from benchmarks.empty_slave import VARIABLES_FILE
from benchmarks.results_page import put
from fmu_packaging.package import Recipe, build
from plant_model.machine_file import read_machine
from scenarios.cosimulation import simulate
from scenarios.scenario import Case, read_scenario

PLAIN_SCRIPT = Path(__file__).with_name("plain_slave.py")
RATIOS = {
    "compensator": ("compensator, real", "compensator, empty", 1.5),
    "compensator, plain": ("compensator, real", "compensator, plain", None),
    "plant": ("plant, real", "plant, empty", None),
}
"""What is compared with what, and the target if there is one."""

CHANGING = {"plant": "ambient", "compensator": "T1"}
"""The input that is another in every step of an FMU alone."""

Fmus = dict[tuple[str, str], Path]


class BareFmu:
    """An FMU, unpacked and initialised, whose real variables lie in arrays; for a ``with``."""

    def __init__(self, path: Path, folder: Path) -> None:
        description = fmpy.read_model_description(str(path), validate=False)
        self._fmu: Any = FMU2Slave(
            guid=description.guid,
            unzipDirectory=fmpy.extract(str(path), unzipdir=str(folder)),
            modelIdentifier=description.coSimulation.modelIdentifier,
            instanceName=path.stem,
        )
        self._fmu.instantiate()
        self.step, self.component = self._fmu.fmi2DoStep, self._fmu.component
        reals = [variable for variable in description.modelVariables if variable.type == "Real"]
        given = [variable for variable in reals if variable.causality == "input"]
        self.names = [variable.name for variable in given]
        self.inputs = np.array([float(variable.start or 0.0) for variable in given])
        shown = [variable for variable in reals if variable.causality == "output"]
        self.set = partial(self._fmu.fmi2SetReal, *self._block(given, self.inputs))
        self.get = partial(self._fmu.fmi2GetReal, *self._block(shown, np.zeros(len(shown))))
        self._fmu.setupExperiment(startTime=0.0)
        self._fmu.enterInitializationMode()
        self.set()
        self._fmu.exitInitializationMode()

    def _block(self, variables: Sequence[Any], values: Any) -> tuple[Any, ...]:
        count = len(variables)
        refs = (ctypes.c_uint * count)(*(variable.valueReference for variable in variables))
        return self.component, refs, count, (ctypes.c_double * count).from_buffer(values.data)

    def __enter__(self) -> BareFmu:
        return self

    def __exit__(self, *raised: object) -> None:
        self._fmu.terminate()
        self._fmu.freeInstance()


def alone(path: Path, folder: Path, steps: int, changing: str) -> float:
    """Return what a step of one FMU costs: real inputs set, the step, real outputs got [us].

    *changing* is the input that is another in every step; the others stay.
    """
    with BareFmu(path, folder) as fmu:
        place = fmu.names.index(changing)
        begun = time.process_time()
        for k in range(steps):
            fmu.inputs[place] = 21.0 + 1e-6 * k
            fmu.set()
            fmu.step(fmu.component, float(k), 1.0, 1)
            fmu.get()
        return (time.process_time() - begun) / steps * 1e6


def _emptied(recipe: Recipe, variables: bytes) -> Recipe:
    """Return a recipe with the same variables and an empty step."""
    return replace(
        recipe,
        module="benchmarks.empty_slave",
        slave="EmptySlave",
        roots=("benchmarks", "fmu_packaging"),
        whole=(),
        third_party={},
        data={VARIABLES_FILE: variables},
    )


def _plain(label: str, variables: bytes, folder: Path) -> Path:
    """Return an FMU of the same variables that pythonfmu's own builder made."""
    # The script's name must be its own: two of one name in a process are one to pythonfmu.
    script, table = folder / f"plain_{label}.py", folder / VARIABLES_FILE
    script.write_bytes(PLAIN_SCRIPT.read_bytes())
    table.write_bytes(variables)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return Path(FmuBuilder.build_FMU(script, dest=folder, project_files=[table]))


def _fmus(folder: Path, model: Path) -> Fmus:
    recipes = {
        "plant": build_fmu.plant_recipe(read_machine(build_fmu.DEFAULT_MACHINE), "plant")[0],
        "compensator": build_fmu.compensator_recipe(model, "compensator")[0],
    }
    found = {}
    for label, recipe in recipes.items():
        package = build(recipe)
        declared = [asdict(variable) for variable in package.slave.variables]
        variables = json.dumps(declared).encode()
        for kind, chosen in (
            ("real", package),
            ("empty", build(_emptied(recipe, variables))),
        ):
            path = folder / f"{kind}_{label}.fmu"
            path.write_bytes(chosen.zipped())
            found[label, kind] = path
        work = folder / f"plain_{label}"
        work.mkdir()
        found[label, "plain"] = _plain(label, variables, work)
    return found


def _runs(fmus: Fmus, case: Case, folder: Path) -> dict[str, Callable[[], float]]:
    """Return what is measured, each as a function that gives the cost of a step [us]."""
    steps = case.settings.steps

    def in_a_folder(run: Callable[..., float], *arguments: Any) -> Callable[[], float]:
        def measure() -> float:
            with tempfile.TemporaryDirectory(dir=folder) as work:
                return run(*arguments, Path(work))

        return measure

    def one(label: str, path: Path, work: Path) -> float:
        return alone(path, work, steps, CHANGING[label])

    def scenario(pair: tuple[Path, Path]) -> Callable[[], float]:
        def measure() -> float:
            # The loop times itself; here by the processor's clock, like the others.
            with patch("scenarios.cosimulation.time.perf_counter", time.process_time):
                return simulate(case, *pair, quiet=True).wall_s / steps * 1e6

        return measure

    runs = {
        f"{label}, {kind}": in_a_folder(one, label, path) for (label, kind), path in fmus.items()
    }
    return runs | {
        "both, scenario loop": scenario((fmus["plant", "real"], fmus["compensator", "real"]))
    }


def measure(steps: int, repeats: int, model: Path) -> dict[str, Any]:
    """Return the costs of a step [us] and their ratios.

    Parameters
    ----------
    steps : int
        Steps of 1 s a run.
    repeats : int
        Runs of each; one more of each warms up and is not counted.
    model : Path
        Compensator file.
    """
    overrides = [("duration_s", float(steps)), ("step_s", 1.0)]
    case = read_scenario("step_speed", overrides).cases[0]
    with tempfile.TemporaryDirectory(prefix="step_cost_") as name:
        runs = _runs(_fmus(Path(name), model), case, Path(name))
        turns = [{title: run() for title, run in runs.items()} for _ in range(repeats + 1)][1:]
    return {
        "steps": steps,
        "repeats": repeats,
        "cost_us": {title: statistics.median(turn[title] for turn in turns) for title in runs},
        "ratios": {
            title: {
                "of": of,
                "to": to,
                "ratio": statistics.median(turn[of] / turn[to] for turn in turns),
                "target": target,
            }
            for title, (of, to, target) in RATIOS.items()
        },
    }


def as_text(found: dict[str, Any]) -> str:
    """Return the figures as lines of text."""
    costs = found["cost_us"]
    lines = ["ratio  target   a step of                  us    against                    us"]
    for entry in found["ratios"].values():
        target = "" if entry["target"] is None else f"{entry['target']:.1f}"
        of, to = entry["of"], entry["to"]
        lines.append(
            f"{entry['ratio']:5.2f}  {target:>6}   {of:<25}{costs[of]:6.1f}"
            f"    {to:<25}{costs[to]:6.1f}"
        )
    pace = 1e6 / costs["both, scenario loop"]
    return "\n".join([*lines, f"simulated seconds a second, steps of 1 s: {pace:.0f}"])


def main() -> int:
    """Measure and print."""
    parser = argparse.ArgumentParser("benchmarks.step_cost", description=__doc__)
    parser.add_argument("--steps", type=int, default=5000, help="steps a run (5000)")
    parser.add_argument("--repeats", type=int, default=7, help="runs of each (7)")
    parser.add_argument("--model", type=Path, default=build_fmu.DEFAULT_MODEL)
    parser.add_argument("--json", action="store_true", help="print JSON")
    parser.add_argument("--write", action="store_true", help="also write docs/results.md")
    arguments = parser.parse_args()
    found = measure(arguments.steps, arguments.repeats, arguments.model)
    if arguments.write:
        put("step_cost", f"```text\n{as_text(found)}\n```")
    print(json.dumps(found, indent=1) if arguments.json else as_text(found))
    return 0


if __name__ == "__main__":
    sys.exit(main())
