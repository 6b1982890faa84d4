"""Where the time of a step goes: both models without an FMU around them, function by function.

``python -m benchmarks.step_profile``
"""

from __future__ import annotations

import argparse
import cProfile
import pstats
import sys
import time
from collections.abc import Callable
from pathlib import Path

import build_fmu
from fmu_compensator.runtime.compensator import RunningCompensator
from fmu_compensator.runtime.modelfile import load_model
from plant_model.machine_file import read_machine
from plant_model.stepper import PlantStepper

MOST = 12


def _compensator(model: Path) -> Callable[[int], None]:
    compensator = RunningCompensator(load_model(str(model)))
    temperatures = [21.0 + 0.1 * place for place in range(len(compensator.model.sensors))]

    def run(k: int) -> None:
        temperatures[0] = 21.0 + 1e-6 * k
        compensator.step(float(k), 1.0, temperatures, 4000.0, 100.0)

    return run


def _plant() -> Callable[[int], None]:
    machine = read_machine(build_fmu.DEFAULT_MACHINE)
    stepper = PlantStepper(machine, None, 1)
    inputs = {entry.name: 21.0 if entry.is_boundary else 0.0 for entry in machine.inputs}
    inputs |= {"speed": 4000.0, "tool_length": 100.0, "dX": 1.0, "dY": 1.0, "dZ": 1.0}
    stepper.reset(inputs)

    def run(k: int) -> None:
        inputs["ambient"] = 21.0 + 1e-6 * k
        stepper.step(1.0, inputs)

    return run


def profile(run: Callable[[int], None], steps: int) -> tuple[float, list[tuple[float, str]]]:
    """Return what a step costs [us], and the functions with the largest share of it [%].

    The cost is measured without the profiler, which makes calls dearer than they are.
    """
    for k in range(steps):
        run(k)
    begun = time.process_time()
    for k in range(steps, 2 * steps):
        run(k)
    cost_us = (time.process_time() - begun) / steps * 1e6
    profiler = cProfile.Profile()
    profiler.enable()
    for k in range(2 * steps, 3 * steps):
        run(k)
    profiler.disable()
    own: dict[str, float] = {}
    for (file, _, name), (_, _, spent, _, _) in pstats.Stats(profiler).stats.items():  # type: ignore[attr-defined]
        if name not in ("run", "<method 'disable' of '_lsprof.Profiler' objects>"):
            place = "built in" if file == "~" else Path(file).name
            own[f"{place}: {name}"] = own.get(f"{place}: {name}", 0.0) + spent
    whole = sum(own.values())
    shares = sorted(((100.0 * spent / whole, name) for name, spent in own.items()), reverse=True)
    return cost_us, shares[:MOST]


def main() -> int:
    """Measure and print."""
    parser = argparse.ArgumentParser("benchmarks.step_profile", description=__doc__)
    parser.add_argument("--steps", type=int, default=5000, help="steps of each part (5000)")
    parser.add_argument("--model", type=Path, default=build_fmu.DEFAULT_MODEL)
    arguments = parser.parse_args()
    for title, run in (("compensator", _compensator(arguments.model)), ("plant", _plant())):
        cost_us, shares = profile(run, arguments.steps)
        print(f"{title}: a step takes {cost_us:.1f} us; share of it in a function's own lines [%]")
        print("\n".join(f"{share:6.1f}  {name}" for share, name in shares) + "\n")
    return 0


if __name__ == "__main__":
    sys.exit(main())
