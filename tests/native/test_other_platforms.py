"""The binaries for Windows, run by Wine, and for aarch64, run by QEMU, beside this machine's."""

import os
import shutil
from pathlib import Path
from random import Random

import pytest

import build_fmu
from fmu_compensator.runtime.modelfile import model_text
from fmu_packaging.native.build import HEADERS, native_package
from fmu_packaging.native.compilers import STRICT, Compiler, compilers, run_compiler
from fmu_packaging.package import Recipe
from plant_model.machine_file import read_machine
from scenarios.building import native_of
from tests.conftest import ROOT
from tests.fmus.models import five_point_table
from tests.native.made import gaussian
from tests.running import cannot_run, output_of

pytestmark = [pytest.mark.long, pytest.mark.usefixtures("every_compiler")]
COMPENSATOR_HOST = Path(__file__).with_name("printing_host.c")
PLANT_HOST = ROOT / "benchmarks" / "plant_host.c"
# Debian puts Wine's program out of the way.
PATH = os.pathsep.join([os.environ["PATH"], "/usr/lib/wine"])
RUN_BY = {"win64": ["wine64"], "aarch64-linux": ["qemu-aarch64", "-L", "/usr/aarch64-linux-gnu"]}


def here_and_there(platform: str) -> tuple[Compiler, Compiler]:
    """Return this machine's compiler and a platform's; skip where either's tools are missing."""
    here, *others = compilers()
    there = [compiler for compiler in others if compiler.platform == platform]
    if not there or not shutil.which(RUN_BY[platform][0], path=PATH):
        cannot_run(f"what makes or runs programs for {platform} is not there")
    return here, *there


def printed(recipe: Recipe, host: Path, compiler: Compiler, folder: Path, *more: object) -> str:
    """Return what a host prints with the FMU of a compiler."""
    package = native_package(recipe, native_of(recipe), [compiler])
    folder.mkdir()
    library = f"library{compiler.suffix}"
    path = f"binaries/{compiler.platform}/{package.name}{compiler.suffix}"
    (folder / library).write_bytes(package.files[path])
    for_windows = compiler.platform == "win64"
    needs = ["-D__USE_MINGW_ANSI_STDIO=1"] if for_windows else ["-ldl"]
    flags = [*STRICT, f"-I{HEADERS}", "-o", "host.exe", str(host), *needs, "-lm"]
    run_compiler([*compiler.command, *flags], folder)
    start = [*RUN_BY.get(compiler.platform, []), "./host.exe", f"./{library}", package.guid]
    wine = {"PATH": PATH, "WINEPREFIX": str(folder / "wine"), "WINEDEBUG": "-all"}
    return output_of(*start, *more, folder=folder, **wine)


@pytest.mark.parametrize("platform", RUN_BY)
def test_the_compensator_gives_the_numbers_and_words_of_this_machine(platform, tmp_path):
    model = tmp_path / "by_hand.json"
    random = gaussian(Random("any host"), 2, 5, fixed=False)
    model.write_text(model_text(five_point_table() | {"gaussian": random}))
    recipe, _ = build_fmu.compensator_recipe(model, "compensator_native", True)
    here, there = (
        printed(recipe, COMPENSATOR_HOST, compiler, tmp_path / compiler.platform).splitlines()
        for compiler in here_and_there(platform)
    )
    assert len(here) == 300
    assert any("T4 is missing" in line for line in here)
    assert any("conditions outside training make" in line for line in here)
    for one, other in zip(here, there, strict=True):
        *numbers, words = one.split(" ", 10)
        *others, same = other.split(" ", 10)
        assert words == same
        assert [*map(float, others)] == pytest.approx([*map(float, numbers)], rel=1e-12, abs=1e-12)


def test_the_plant_gives_the_numbers_of_this_machine(tmp_path):
    recipe, _ = build_fmu.plant_recipe(read_machine("jig_borer"), "plant_native")
    variables = native_package(recipe, native_of(recipe), []).slave.variables
    outputs = [place for place, variable in enumerate(variables) if variable.is_output]
    inputs = sum(variable.causality == "input" for variable in variables)
    more = [3000, inputs, outputs[0], len(outputs), 3000, 9000, 6000]
    one, other = (
        float(printed(recipe, PLANT_HOST, compiler, tmp_path / compiler.platform, *more).split()[1])
        for compiler in here_and_there("aarch64-linux")
    )
    assert abs(one) > 1.0
    assert abs(one - other) < 1e-8
