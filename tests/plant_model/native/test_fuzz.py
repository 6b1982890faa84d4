"""The plant's FMU under the sanitizers, called in random order with random arguments."""

from __future__ import annotations

import subprocess
from collections.abc import Sequence
from pathlib import Path

import pytest

from fmu_packaging.native.build import front
from fmu_packaging.native.compilers import STRICT, c_files, run_compiler, write_sources
from plant_model.fmi_slave import variables
from plant_model.machine_file import read_machine
from plant_model.native.generate import machine_sources, program, variable_sources
from tests.patience import PATIENCE_S
from tests.plant_model.native.test_twin import with_all_effects

HERE = Path(__file__).resolve().parent
SANITIZED = ("-g", "-O0", "-fsanitize=address,undefined", "-fno-sanitize-recover=all")
CALLS = [6_000, pytest.param(60_000, marks=pytest.mark.long)]


@pytest.mark.parametrize("calls", CALLS)
def test_fuzzed_calls_are_clean(calls: int, compiler: tuple[str, ...], tmp_path: Path) -> None:
    machine = with_all_effects(read_machine("jig_borer_lumps"))
    sources = {**front(2), **program(), **machine_sources(machine)}
    sources["model_data.c"] = variable_sources(variables(machine), "fuzz", "{0}")
    fuzz(sources, calls, compiler, tmp_path)


def fuzz(sources: dict[str, str], calls: int, compiler: Sequence[str], folder: Path) -> None:
    """Call an FMU's functions in random order under the sanitizers."""
    sources = {**sources, "fuzz.c": (HERE / "fuzz.c").read_text()}
    write_sources(folder, sources)
    command = [*compiler, *STRICT, *SANITIZED, "-I.", "-o", "fuzz", *c_files(sources), "-lm"]
    run_compiler(command, folder)
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
