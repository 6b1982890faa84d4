"""Whether Python and C agree: random machines and compensators, every effect, faulty inputs.

The plant: four machines, one of them a drawing page, with every effect, each parameter within 10 %
of its nominal value, and random inputs, step lengths, tools and offsets. In each case a share of
the effects is on; the more effects, the fewer steps, because with all of them a step of the plant
in Python takes up to 30 ms. The compensator: random files of every error model, readings that are
missing, infinite, absurd, stale or jump, a clock that jumps, impossible tools and speeds; under the
address and undefined-behaviour sanitizers. The machines, files and faults are those of the tests,
with other random numbers.
``python -m benchmarks.native_agreement``
"""

from __future__ import annotations

import argparse
import sys
import tempfile
from collections import Counter
from collections.abc import Callable, Iterator
from math import isfinite, isnan, nan
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pandas as pd

from fmu_compensator.runtime.compensator import RunningCompensator
from fmu_compensator.runtime.modelfile import Model
from fmu_packaging.native.compilers import compilers
from plant_model.effects import catalogue
from plant_model.machine import Machine
from plant_model.stepper import PlantStepper
from tests.native.conftest import Driver, compile_program, drivers
from tests.native.made import MADE, Samples, made_model
from tests.native.test_twin import STEPS as SAMPLES
from tests.native.test_twin import line_of
from tests.plant_model.native.conftest import core_of
from tests.plant_model.native.test_twin import (
    MACHINES,
    differences,
    started,
    values_of,
    with_all_effects,
)

CLOSE = 1e-8
SHARES = {0.05: 8000, 0.1: 4000, 0.2: 1500, 0.4: 400, 1.0: 60}
"""Number of steps of a case, by the share of the effects that are on."""
SEED = 2026

NO_MACHINE = 1000.0
"""Temperature above which a case is stopped, because random effects may heat without cooling
[degC]. There, displacements are small differences of large growths, and rounding shows."""


class Case(NamedTuple):
    """The result of a case: the largest difference, and whether both sides refused to go on.

    It is *burnt* if a lump got too hot to compare.
    """

    of: str
    name: str
    steps: int
    largest: float
    refused: bool = False
    burnt: bool = False


def numbers_of(machine: Machine, rng: np.random.Generator, share_on: float) -> dict[str, float]:
    """Return random values for all parameters of a machine, and which effects are on."""
    known = machine.parameters
    found = {}
    for name, entry in known.items():
        if entry.tied:
            continue
        near = entry.value * (1.0 + rng.uniform(-0.1, 0.1))
        found[name] = float(np.clip(near, entry.low, entry.high))
    return found | values_of(machine, rng, share_on)


def plants(steps: int, folder: Path, effects: Counter[str]) -> Iterator[Case]:
    """Compare plants until there are enough steps; count the cases in which each effect was on."""
    machines = [with_all_effects(machine) for machine in MACHINES]
    for machine in machines:
        (folder / machine.name).mkdir()
    command = compilers()[0].command
    libraries = [core_of(machine, command, folder / machine.name) for machine in machines]
    done = case = 0
    while done < steps:
        place = case % len(machines)
        share = list(SHARES)[case // len(machines) % len(SHARES)]
        machine, count = machines[place], SHARES[share]
        rng = np.random.default_rng([SEED, case])
        values = numbers_of(machine, rng, share)
        python, core, inputs = started(machine, libraries[place], values, rng)
        found, burnt = [], False
        for one in differences(machine, python, core, rng, inputs, count):
            found.append(one)
            burnt = hottest(python) > NO_MACHINE
            if burnt:
                break
        refused = len(found) < count and not burnt
        name = f"case {case}, {share:g} of the effects on"
        yield Case(machine.name, name, len(found), max(found, default=0.0), refused, burnt)
        effects.update({key.partition(":")[0] for key in machine.effects if is_on(key, values)})
        done, case = done + len(found), case + 1


def hottest(plant: PlantStepper) -> float:
    """Return the largest absolute temperature of a plant's lumps [degC]."""
    state = plant.state()
    return max(map(abs, state["state"][: len(state["start"])]))


def is_on(key: str, values: dict[str, float]) -> bool:
    """Return whether an effect is on."""
    effect = catalogue()[key.partition(":")[0]]
    return values[f"effects.{key}.{effect.amplitude}"] != effect.off


def compensators(steps: int, folder: Path) -> Iterator[Case]:
    """Compare compensators until there are enough samples."""
    command, compiled = compilers()[0].command, folder / "compensators"
    compile_program(command, compiled)
    driver_of = drivers(command, compiled, folder)
    for turn in range(-(-steps // (SAMPLES * len(MADE)))):
        seed = 1000 + turn  # above the seeds of the tests
        for kind in sorted(MADE):
            yield Case(kind, f"{kind} {seed}", SAMPLES, compared(kind, seed, driver_of))


def compared(kind: str, seed: int, driver_of: Callable[[Model], Driver]) -> float:
    """Return the largest difference in any output of a random compensator."""
    model = made_model(kind, seed)
    compensator, samples = RunningCompensator(model), Samples(model, seed)
    lines: list[str] = []
    expected = []
    for _ in range(SAMPLES):
        sample = samples.next()
        lines += line_of(model, sample)
        expected.append(compensator.step(*sample))
    driver = driver_of(model)
    found = driver.run(lines)
    driver.path.unlink()
    return max(apart(*pair) for pair in zip(found, expected, strict=True))


def apart(parts: list[str], output: tuple[object, ...]) -> float:
    """Return the largest difference in an output, relative to it if it is above 1 um or urad."""
    numbers = [float.fromhex(value) for value in parts[1].split()]
    worst = 0.0 if parts[-1] == output[-1] else nan
    for one, other in zip(numbers, map(float, output[:-1]), strict=True):  # type: ignore[arg-type]
        if one == other or (isnan(one) and isnan(other)):
            continue
        off = abs(one - other) / max(1.0, abs(other)) if isfinite(one) else nan
        worst = off if not off <= worst else worst
    return worst


def show(title: str, cases: Iterator[Case]) -> bool:
    """Print a table; return whether all cases agreed."""
    found = pd.DataFrame(cases)
    beyond = found[~(found.largest < CLOSE)]
    sums = {column: (column, "sum") for column in ("steps", "refused", "burnt")}
    table = found.groupby("of").agg(cases=("name", "size"), largest=("largest", "max"), **sums)
    print(f"{title}\n{table.rename_axis(None)}")
    print(f"{found.steps.sum()} steps, {len(beyond)} cases beyond {CLOSE:g}\n")
    for case in beyond.head(10).itertuples():
        print(f"  {case.name}: {case.largest:.1e}")
    return beyond.empty


def main() -> int:
    """Compare, and print two tables; return 1 if anything differs."""
    parser = argparse.ArgumentParser("benchmarks.native_agreement", description=__doc__)
    parser.add_argument("--steps", type=int, default=1_000_000, help="of each kind (1000000)")
    given = parser.parse_args()
    effects = Counter[str]()
    with tempfile.TemporaryDirectory(prefix="native_agreement_") as name:
        folder = Path(name)
        agreed = show("plant [um, degC, K]", plants(given.steps, folder, effects))
        least = min(effects[name] for name in catalogue())
        print(f"{len(effects)} effects, each on in {least} cases or more\n")
        agreed &= show("compensator", compensators(given.steps, folder))
    return 0 if agreed else 1


if __name__ == "__main__":
    sys.exit(main())
