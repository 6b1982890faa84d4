"""The binaries for aarch64, run by QEMU, beside those for this machine."""

import os
import shutil
import subprocess
from pathlib import Path

import pytest

import build_fmu
from fmu_packaging.native.build import HEADERS, native_package
from fmu_packaging.native.compilers import FOR_AARCH64, STRICT, Compiler, compilers, run_compiler
from fmu_packaging.package import Recipe
from plant_model.machine_file import read_machine
from scenarios.building import native_of
from tests.conftest import ROOT
from tests.native.test_windows import model_of_the_host, same_lines

COMPENSATOR_HOST = Path(__file__).with_name("printing_host.c")
PLANT_HOST = ROOT / "benchmarks" / "plant_host.c"
QEMU, LIBRARIES = "qemu-aarch64", "/usr/aarch64-linux-gnu"


@pytest.fixture(scope="module")
def both(every_compiler: None) -> list[tuple[Compiler, list[str]]]:
    """Each compiler, and how its programs are started."""
    lost = [name for name in (FOR_AARCH64, QEMU) if shutil.which(name) is None]
    if lost:
        problem = f"{lost[0]} is not there"
        pytest.fail(problem) if os.environ.get("CI") else pytest.skip(problem)
    here, *others = compilers()
    (other,) = (found for found in others if found.platform == "aarch64-linux")
    return [(here, []), (other, [QEMU, "-L", LIBRARIES])]


@pytest.mark.long
def test_the_compensator_gives_the_numbers_and_words_of_this_machine(both, tmp_path):
    model = model_of_the_host(tmp_path)
    recipe, _ = build_fmu.compensator_recipe(model, "compensator_native", True)
    here, there = (
        printed(recipe, COMPENSATOR_HOST, entry, tmp_path / entry[0].platform) for entry in both
    )
    same_lines(here.splitlines(), there.splitlines())


@pytest.mark.long
def test_the_plant_gives_the_numbers_of_this_machine(both, tmp_path):
    machine = read_machine("jig_borer")
    recipe, _ = build_fmu.plant_recipe(machine, "plant_native")
    variables = native_package(recipe, native_of(recipe), []).slave.variables
    outputs = [place for place, variable in enumerate(variables) if variable.is_output]
    inputs = sum(variable.causality == "input" for variable in variables)
    more = [3000, inputs, outputs[0], len(outputs), 3000, 9000, 6000]
    here, there = (
        printed(recipe, PLANT_HOST, entry, tmp_path / entry[0].platform, *map(str, more))
        for entry in both
    )
    one, other = (float(line.split()[1]) for line in (here, there))
    assert abs(one) > 1.0
    assert abs(one - other) < 1e-8


def printed(
    recipe: Recipe, host: Path, entry: tuple[Compiler, list[str]], folder: Path, *more: str
) -> str:
    """Return what a host prints with the FMU of a compiler."""
    compiler, start = entry
    package = native_package(recipe, native_of(recipe), [compiler])
    folder.mkdir()
    path = f"binaries/{compiler.platform}/{package.name}{compiler.suffix}"
    (folder / "library.so").write_bytes(package.files[path])
    command = [*compiler.command, *STRICT, f"-I{HEADERS}", "-o", "host", str(host), "-ldl", "-lm"]
    run_compiler(command, folder)
    command = [*start, "./host", "./library.so", package.guid, *more]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return done.stdout
