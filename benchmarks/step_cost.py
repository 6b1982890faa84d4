"""What a co-simulated step costs, against two FMUs of the same variables with an empty step.

Same master, same scenario, same packaging; the two pairs take turns and the median is printed.
``python -m benchmarks.step_cost``
"""

from __future__ import annotations

import argparse
import json
import statistics
import sys
import tempfile
from dataclasses import asdict, replace
from pathlib import Path

import build_fmu
from benchmarks.empty_slave import VARIABLES_FILE
from fmu_packaging.package import Recipe, build
from plant_model.machine_file import read_machine
from scenarios.cosimulation import simulate
from scenarios.scenario import Case, read_scenario


def _emptied(recipe: Recipe) -> Recipe:
    """Return a recipe with the same variables and an empty step."""
    variables = [asdict(variable) for variable in build(recipe).slave.variables]
    return replace(
        recipe,
        module="benchmarks.empty_slave",
        slave="EmptySlave",
        roots=("benchmarks", "fmu_packaging"),
        whole=(),
        third_party={},
        data={VARIABLES_FILE: json.dumps(variables).encode()},
    )


def _pairs(folder: Path, model: Path) -> dict[str, tuple[Path, Path]]:
    recipes = (
        build_fmu.plant_recipe(read_machine(build_fmu.DEFAULT_MACHINE), "plant")[0],
        build_fmu.compensator_recipe(model, "compensator")[0],
    )
    pairs = {}
    for kind, chosen in (("real", recipes), ("empty", tuple(map(_emptied, recipes)))):
        paths = []
        for recipe in chosen:
            path = folder / f"{kind}_{recipe.identity.name}.fmu"
            path.write_bytes(build(recipe).zipped())
            paths.append(path)
        pairs[kind] = (paths[0], paths[1])
    return pairs


def _case(steps: int) -> Case:
    scenario = read_scenario("step_speed", [("duration_s", float(steps)), ("step_s", 1.0)])
    return scenario.cases[0]


def measure(steps: int, repeats: int, model: Path) -> dict[str, float]:
    """Return the cost of a step of each pair [us], their ratio, and simulated seconds a second.

    Parameters
    ----------
    steps : int
        Steps of 1 s a run.
    repeats : int
        Runs of each pair; one more of each warms up and is not counted.
    model : Path
        Compensator file.
    """
    case = _case(steps)
    costs: dict[str, list[float]] = {"real": [], "empty": []}
    with tempfile.TemporaryDirectory(prefix="step_cost_") as folder:
        pairs = _pairs(Path(folder), model)
        for repeat in range(repeats + 1):
            for kind, pair in pairs.items():
                wall_s = simulate(case, *pair, quiet=True).wall_s
                if repeat:
                    costs[kind].append(wall_s / steps * 1e6)
    medians = {kind: statistics.median(values) for kind, values in costs.items()}
    # Each turn's two runs lie side by side in time, so their ratio suffers least from other load.
    turns = zip(costs["real"], costs["empty"], strict=True)
    return {
        "real_us": medians["real"],
        "empty_us": medians["empty"],
        "ratio": statistics.median(real / empty for real, empty in turns),
        "simulated_s_per_s": 1e6 / medians["real"],
        "steps": steps,
        "repeats": repeats,
    }


def main() -> int:
    """Measure and print."""
    parser = argparse.ArgumentParser("benchmarks.step_cost", description=__doc__)
    parser.add_argument("--steps", type=int, default=7200, help="steps a run (7200)")
    parser.add_argument("--repeats", type=int, default=7, help="runs of each pair (7)")
    parser.add_argument("--model", type=Path, default=build_fmu.DEFAULT_MODEL)
    parser.add_argument("--json", action="store_true", help="print JSON")
    arguments = parser.parse_args()
    found = measure(arguments.steps, arguments.repeats, arguments.model)
    if arguments.json:
        print(json.dumps(found, indent=1))
        return 0
    print(f"a co-simulated step, plant and compensator: {found['real_us']:.1f} us")
    print(f"the floor, two FMUs with an empty step:     {found['empty_us']:.1f} us")
    print(f"ratio, median of {arguments.repeats}: {found['ratio']:.2f}")
    print(f"simulated seconds a second: {found['simulated_s_per_s']:.0f}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
