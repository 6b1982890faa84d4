"""The plant's FMU under the sanitizers, called in random order with random arguments."""

import subprocess
from collections.abc import Sequence
from pathlib import Path

import pytest

from fmu_packaging.native import compilers
from fmu_packaging.native.build import front
from fmu_packaging.native.compilers import STRICT, c_files, write_sources
from plant_model.fmi_slave import variables
from plant_model.machine_file import read_machine
from plant_model.native.continuous import continuous_variables, is_continuous
from plant_model.native.equations import equations_of
from plant_model.native.generate import machine_sources, program, tunable_of, variable_sources
from tests.patience import PATIENCE_S
from tests.plant_model.catalogue_machines import lathe
from tests.plant_model.conftest import with_effects
from tests.plant_model.native.test_twin import with_all_effects

HERE = Path(__file__).resolve().parent
SANITIZED = ("-g", "-O0", "-fsanitize=address,undefined", "-fno-sanitize-recover=all")


@pytest.mark.long
@pytest.mark.parametrize("whole", [True, False])
@pytest.mark.parametrize(
    ("calls", "machine"),
    [
        # Of seven nodes, which the sanitizers compile soon, and without a number to calibrate.
        (6_000, lathe()),
        pytest.param(60_000, read_machine("jig_borer_lumps"), marks=pytest.mark.long),
    ],
    ids=["short", "long"],
)
def test_fuzzed_calls_are_clean(calls, machine, whole, compiler, tmp_path):
    # With all effects it is for co-simulation only.
    machine = with_all_effects(machine) if whole else with_effects(machine, "radiation")
    equations = equations_of(machine, tunable_of(machine))
    assert is_continuous(equations) != whole
    known = {variable.name: variable for variable in variables(machine)}
    known |= {} if whole else continuous_variables(machine, equations, tunable_of(machine))
    sources = {**front(2), **program(), **machine_sources(machine, equations)}
    sources["model_data.c"] = variable_sources(list(known.values()), "fuzz", "{0}")
    fuzz(sources, calls, compiler, tmp_path)


def fuzz(sources: dict[str, str], calls: int, compiler: Sequence[str], folder: Path) -> None:
    """Call an FMU's functions in random order under the sanitizers."""
    sources = {**sources, "fuzz.c": (HERE / "fuzz.c").read_text()}
    write_sources(folder, sources)
    command = [*compiler, *STRICT, *SANITIZED, "-I.", "-o", "fuzz", *c_files(sources), "-lm"]
    compilers.run_compiler(command, folder)
    done = subprocess.run(
        [str(folder / "fuzz"), "1", str(calls)],
        capture_output=True,
        text=True,
        check=False,
        timeout=PATIENCE_S,
    )
    assert done.returncode == 0, done.stderr
    well, discarded, refused = map(int, done.stdout.split())
    assert min(well, discarded, refused) > 20
