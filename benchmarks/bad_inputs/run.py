"""Give every command bad input, and see what it says.

    python -m benchmarks.bad_inputs.run [--write]

Each case runs in a folder of its own with good files of which some are spoilt. Promised are exit
code 2, one line that names file, place, value and what is allowed, and that no file is lost,
changed or half-written.
"""

from __future__ import annotations

import tempfile
from collections.abc import Sequence
from pathlib import Path

from tqdm import tqdm

from benchmarks.bad_inputs.case import GROUPS, Answer, BadInputCase, ask
from benchmarks.results_page import as_table, parser_of, put
from fmu_compensator.fit.fitting import compensator_text, fit_compensator
from fmu_packaging.package import build
from fmu_packaging.publish import publish
from measurement.rig import rig_from_table
from measurement.runs import read_run
from plant_model.machine_file import machine_path, read_machine
from scenarios.building import DEFAULT_MODEL, compensator_recipe, plant_recipe
from scenarios.cli import main as spindle_drift
from scenarios.scenario import scenario_path

SHOWN = 3
"""Cases of each group that the page shows [1]."""
ROOT = Path(__file__).resolve().parents[2]
RUNS = {"a": "training_down", "b": "training_random", "c": "training_stops", "d": "stop_and_go"}


def good_files() -> dict[str, bytes]:
    """Return files that every command takes: four runs, a compensator, a machine, a scenario."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for run, scenario in RUNS.items():
            path = folder / f"{run}.csv"
            told = ["simulate", scenario, "--every", "120", "-o", str(path)]
            assert spindle_drift(told) == 0
        machine = read_machine("jig_borer")
        runs = [read_run(folder / f"{run}.csv") for run in "abc"]
        table = fit_compensator(runs, rig_from_table(machine.rig, "rig"), "mlr")
        (folder / "c.json").write_text(compensator_text(table), encoding="utf-8")
        page = ["new-machine", "-o", str(folder / "page.toml"), "--bearing", "7014"]
        assert spindle_drift([*page, "--speed", "12000", "--power", "15"]) == 0
        (folder / "lumps.toml").write_bytes(machine_path("jig_borer_lumps").read_bytes())
        (folder / "s.toml").write_bytes(scenario_path("stop_and_go").read_bytes())
        return {path.name: path.read_bytes() for path in folder.iterdir()}


def build_into(folder: Path) -> None:
    """Build the FMUs that commands take by default."""
    recipes = [
        compensator_recipe(DEFAULT_MODEL, "compensator"),
        plant_recipe(read_machine("jig_borer"), "plant"),
    ]
    for recipe, reference in recipes:
        publish(build(recipe), folder, reference)


def answers(cases: Sequence[BadInputCase], good: dict[str, bytes], dist: Path) -> list[Answer]:
    """Return what is said of each case; *dist* is where built FMUs are."""
    found = []
    for case in tqdm(cases, disable=None, leave=False):
        with tempfile.TemporaryDirectory() as name:
            folder = Path(name) / "work"
            folder.mkdir()
            found.append(ask(case, good, folder, dist))
    return found


def tables(found: dict[str, list[Answer]], shown: int = 10**6) -> str:
    """Return a table for each group, of so many of its cases and of all that were not kept."""
    everything = [answer for group in found.values() for answer in group]
    kept = sum(not answer.problem for answer in everything)
    lines = [f"{kept} of {len(everything)} keep all of it.", ""]
    for name, group in found.items():
        rows = []
        first = group[:shown]
        for answer in first + [answer for answer in group[shown:] if answer.problem]:
            case = answer.case
            line = answer.line.strip().removeprefix("spindle-drift: error: ")
            line = line.replace(f"{ROOT}/", "").replace("|", "\\|")
            said = answer.problem.replace("|", "\\|") if answer.problem else line
            mark = "**not kept**: " if answer.problem else ""
            rows.append([case.title, f"`{case.command.format(dist='dist')}`", mark + said])
        table = as_table(["What is wrong", "Command", "What is said"], rows)
        lines += [f"### {name}", "", table, ""]
    return "\n".join(lines)


def main() -> int:
    """Ask all, and print or write the tables; 1 if a promise was not kept."""
    parser = parser_of(__doc__)
    args = parser.parse_args()
    good = good_files()
    with tempfile.TemporaryDirectory() as dist:
        build_into(Path(dist))
        found = {name: answers(cases, good, Path(dist)) for name, cases in GROUPS.items()}
    print(tables(found))
    if args.write:
        put("bad_inputs", tables(found, SHOWN))
    return int(any(answer.problem for group in found.values() for answer in group))


if __name__ == "__main__":
    raise SystemExit(main())
