"""The C program under the sanitizers, compiled once, and linked with the data of any model."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import pytest

from fmu_compensator.native.generate import constants, data_sources, program
from fmu_compensator.runtime.fmi_slave import variables
from fmu_compensator.runtime.modelfile import Model
from fmu_packaging.native.build import front
from fmu_packaging.native.compilers import STRICT, c_files, run_compiler, write_sources
from tests.conftest import built, once
from tests.fmus.models import five_point_text
from tests.running import output_of

HERE = Path(__file__).resolve().parent
SANITIZED = ("-g", "-O0", "-fsanitize=address,undefined", "-fno-sanitize-recover=all")
CHECKED = (*STRICT, *SANITIZED, "-I.")


@pytest.fixture(scope="session", autouse=True)
def compiled_here(compiler: tuple[str, ...]) -> None:
    """Nothing of this room runs without a compiler."""


@pytest.fixture(scope="session")
def by_hand(shared: Path) -> Path:
    """A compensator file made by hand, by_hand.json, and beside it its FMUs of every form."""

    def make(new: Path) -> None:
        new.mkdir()
        model = new / "by_hand.json"
        model.write_text(five_point_text())
        for form in ((), ("--native",), ("--fmi", "3"), ("--can",), ("--can", "high")):
            built(new, *form, "--only", "compensator", "--model", str(model))

    return once(shared / "by_hand", make)


@dataclass(frozen=True)
class Driver:
    """A program that runs one model: see driver.c for its lines."""

    path: Path

    def run(self, lines: Sequence[str]) -> list[list[str]]:
        """Return what each line shows, part by part; the last part is the text."""
        shown = output_of(self.path, given="\n".join(lines) + "\n")
        return [line.split("|", 10) for line in shown.splitlines()]


@pytest.fixture(scope="session")
def driver_of(
    compiler: tuple[str, ...], shared: Path, tmp_path_factory: pytest.TempPathFactory
) -> Callable[[Model], Driver]:
    """Makes the program that runs a model."""
    compiled = once(shared / "driver", partial(compile_program, compiler))
    return drivers(compiler, compiled, tmp_path_factory.mktemp("driver"))


def compile_program(compiler: Sequence[str], new: Path) -> None:
    """Compile all of the program but a model's data into a new folder."""
    sources = {**front(2), **program(), "constants.h": constants()}
    sources |= {"driver.c": (HERE / "driver.c").read_text()}
    new.mkdir()
    write_sources(new, sources)
    run_compiler([*compiler, *CHECKED, "-c", *c_files(sources)], new)


def drivers(compiler: Sequence[str], compiled: Path, folder: Path) -> Callable[[Model], Driver]:
    """Return what makes the program that runs a model, in a folder, of what is compiled already."""

    def driver(model: Model) -> Driver:
        data = data_sources(model, variables(model), model.name, "{0}")
        write_sources(folder, {f"{model.name}.c": data})
        objects = [str(path) for path in sorted(compiled.glob("*.o"))]
        command = [*compiler, *CHECKED, f"-I{compiled}", "-o", model.name, f"{model.name}.c"]
        run_compiler([*command, *objects, "-lm"], folder)
        return Driver(folder / model.name)

    return driver
