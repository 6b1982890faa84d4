"""The component in C, with the compensator inside the control: no Python, no bus."""

from __future__ import annotations

import tempfile
from pathlib import Path

from fmu_compensator.native.build import native_compensator
from fmu_packaging.native.build import front
from fmu_packaging.native.compilers import (
    STRICT,
    CompileError,
    NativeError,
    c_files,
    compilers,
    run_compiler,
    write_sources,
)
from fmu_packaging.package import slave_of
from measurement.errors import BadInput, one_line
from measurement.files import sha256_of
from scenarios.building import compensator_recipe

SOURCES = Path(__file__).with_name("native")
HEADERS = Path("/usr/include/linuxcnc")
FLAGS = ("-O2", "-DULAPI", "-DUSPACE", "-isystem", str(HEADERS))
LIBRARIES = ("-llinuxcnchal", "-lm")


def component_sources(compensator: Path) -> dict[str, str]:
    """Return the C sources of a compensator file's component, by path.

    Parameters
    ----------
    compensator : Path
        The compensator file.

    Raises
    ------
    BadInput
        If it cannot be read, or its model has no C code.
    """
    recipe, _ = compensator_recipe(compensator, compensator.stem, native=True)
    try:
        native = native_compensator(recipe)
        data = native.data(slave_of(recipe).variables, sha256_of(compensator)[:60])
    except NativeError as error:
        raise BadInput(compensator, "", str(error)) from None
    own = {path.name: path.read_text("utf-8") for path in SOURCES.glob("*.[ch]")}
    fmi = {name: text for name, text in front(2).items() if not name.startswith("fmi")}
    return {**fmi, **native.program, **data, **own}


def build_component(compensator: Path, target: Path) -> None:
    """Build the component of a compensator file.

    Parameters
    ----------
    compensator : Path
        The compensator file.
    target : Path
        The program to build.

    Raises
    ------
    BadInput
        If there is no compiler, or LinuxCNC's headers are missing.
    """
    if not (HEADERS / "hal.h").exists():
        raise BadInput(HEADERS / "hal.h", "", "is missing (package linuxcnc-uspace-dev)")
    sources = component_sources(compensator)
    with tempfile.TemporaryDirectory(prefix="component_") as name:
        folder = Path(name)
        write_sources(folder, sources)
        try:
            command = compilers()[0].command
            files = c_files(sources)
            run_compiler(
                [*command, *STRICT, *FLAGS, "-I.", "-o", "thermal", *files, *LIBRARIES], folder
            )
        except (NativeError, CompileError) as error:
            raise BadInput(compensator, "", one_line(error)) from None
        made = target.with_name(f"{target.name}.new")
        made.write_bytes((folder / "thermal").read_bytes())
        made.chmod(0o755)
        made.replace(target)
