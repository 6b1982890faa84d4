"""Whether Python and C agree: random machines and compensators, every effect, faulty inputs.

The plant: four machines, one of them a page, with every effect in force, each number within 10 % of
its nominal one, random inputs, step lengths, tools and offsets. A case has a share of the effects
on, and as many steps as it can afford: with all effects a step of the plant in Python takes up to
30 ms. The compensator: random files of every error model, readings that are missing, infinite,
absurd, jumped and stale, a clock that jumps, tools and speeds that cannot be; under the address and
undefined-behaviour sanitizers. The machines, files and faults are those of the tests, with other
random numbers. Ctrl-C ends a comparison early; what was compared until then is told.
``python -m benchmarks.native_agreement``
"""

from __future__ import annotations

import argparse
import sys
import tempfile
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import suppress
from dataclasses import dataclass, field
from math import isfinite, isnan, nan
from pathlib import Path

import numpy as np

from fmu_compensator.runtime.compensator import RunningCompensator
from fmu_compensator.runtime.modelfile import Model
from fmu_packaging.native.compilers import compilers
from plant_model.effects import catalogue
from plant_model.machine import Machine
from plant_model.stepper import PlantStepper
from tests.native.conftest import Driver, drivers
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
"""Steps of a case, by the share of the effects that are on."""
SEED = 2026

NO_MACHINE = 1000.0
"""Random effects may heat without cooling; hotter than this a case is left off [degC]. There
displacements are small differences of large growths, and rounding shows."""


@dataclass
class Tally:
    """What a kind of plant or compensator came to.

    A case *ended* where both refused a step, and was *burnt* where a lump got too hot to compare.
    """

    steps: int = 0
    cases: int = 0
    worst: float = 0.0
    beyond: list[str] = field(default_factory=list)
    ended: int = 0
    burnt: int = 0

    def add(self, steps: int, worst: float, name: str) -> None:
        self.steps, self.cases = self.steps + steps, self.cases + 1
        self.worst = max(self.worst, worst)
        if not worst < CLOSE:
            self.beyond.append(f"{name}: {worst:.1e}")


def numbers_of(machine: Machine, rng: np.random.Generator, share_on: float) -> dict[str, float]:
    """Return random numbers for all of a machine: values, and which effects are on."""
    known = machine.parameters
    found = {}
    for name, entry in known.items():
        if entry.tied:
            continue
        near = entry.value * (1.0 + rng.uniform(-0.1, 0.1))
        found[name] = float(np.clip(near, entry.low, entry.high))
    return found | values_of(machine, rng, share_on)


def plants(steps: int, folder: Path, effects: Counter[str]) -> Iterator[tuple[str, Tally]]:
    """Compare plants until there are enough steps, and count in how many cases an effect was on."""
    machines = [with_all_effects(machine) for machine in MACHINES]
    for machine in machines:
        (folder / machine.name).mkdir()
    command = compilers()[0].command
    libraries = [core_of(machine, command, folder / machine.name) for machine in machines]
    tallies, case = [Tally() for _ in machines], 0
    with suppress(KeyboardInterrupt):
        while sum(tally.steps for tally in tallies) < steps:
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
            name = f"case {case}, {share:g} of the effects on"
            tallies[place].add(len(found), max(found, default=0.0), name)
            tallies[place].ended += len(found) < count and not burnt
            tallies[place].burnt += burnt
            effects.update({key.partition(":")[0] for key in machine.effects if is_on(key, values)})
            case += 1
    yield from zip((machine.name for machine in machines), tallies, strict=True)


def hottest(plant: PlantStepper) -> float:
    """Return the largest temperature of a plant's lumps, without sign [degC]."""
    state = plant.state()
    return max(map(abs, state["state"][: len(state["start"])]))


def is_on(key: str, values: dict[str, float]) -> bool:
    """Return whether an effect is on."""
    effect = catalogue()[key.partition(":")[0]]
    return values[f"effects.{key}.{effect.amplitude}"] != effect.off


def compensators(steps: int, folder: Path) -> Iterator[tuple[str, Tally]]:
    """Compare compensators until there are enough samples."""
    driver_of = drivers(compilers()[0].command, folder)
    tallies = {kind: Tally() for kind in sorted(MADE)}
    seed = 1000  # beyond those of the tests
    with suppress(KeyboardInterrupt):
        while sum(tally.steps for tally in tallies.values()) < steps:
            for kind, tally in tallies.items():
                tally.add(SAMPLES, compared(kind, seed, driver_of), f"{kind} {seed}")
            seed += 1
    yield from tallies.items()


def compared(kind: str, seed: int, driver_of: Callable[[Model], Driver]) -> float:
    """Return the largest difference of any output of a random compensator."""
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
    """Return the largest difference of an output; above 1 um or urad, relative to it."""
    numbers = [float.fromhex(value) for value in parts[1].split()]
    worst = 0.0 if parts[-1] == output[-1] else nan
    for one, other in zip(numbers, map(float, output[:-1]), strict=True):  # type: ignore[arg-type]
        if one == other or (isnan(one) and isnan(other)):
            continue
        off = abs(one - other) / max(1.0, abs(other)) if isfinite(one) else nan
        worst = off if not off <= worst else worst
    return worst


def show(title: str, unit: str, rows: Iterator[tuple[str, Tally]]) -> bool:
    """Print a table; return whether everything agreed."""
    print(f"{title:16}{'cases':>7}{'steps':>10}  largest difference [{unit}]", flush=True)
    found = dict(rows)
    for name, tally in found.items():
        ended = f", both refused a step in {tally.ended} cases" if tally.ended else ""
        if tally.burnt:
            ended += f", left off above {NO_MACHINE:g} degC in {tally.burnt}"
        print(f"{name:16}{tally.cases:7}{tally.steps:10}  {tally.worst:.1e}{ended}")
    beyond = [line for tally in found.values() for line in tally.beyond]
    steps = sum(tally.steps for tally in found.values())
    print(f"{'all':16}{'':7}{steps:10}  {len(beyond)} cases beyond {CLOSE:g}\n")
    for line in beyond[:10]:
        print(f"  {line}")
    return not beyond


def main() -> int:
    """Compare, and print two tables; return 1 if anything differs."""
    parser = argparse.ArgumentParser("benchmarks.native_agreement", description=__doc__)
    parser.add_argument("--steps", type=int, default=1_000_000, help="of each kind (1000000)")
    parser.add_argument("--only", choices=("plant", "compensator"))
    given = parser.parse_args()
    agreed, effects = True, Counter[str]()
    with tempfile.TemporaryDirectory(prefix="native_agreement_") as name:
        for kind in ("plant", "compensator"):
            (Path(name) / kind).mkdir()
        if given.only != "compensator":
            rows = plants(given.steps, Path(name) / "plant", effects)
            agreed &= show("plant", "um, degC, K", rows)
            least = min((effects[key], key) for key in catalogue())
            print(f"{len(effects)} effects, each on in {least[0]} cases or more\n")
        if given.only != "plant":
            rows = compensators(given.steps, Path(name) / "compensator")
            agreed &= show("compensator", "1", rows)
    return 0 if agreed else 1


if __name__ == "__main__":
    sys.exit(main())
