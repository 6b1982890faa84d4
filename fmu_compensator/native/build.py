"""The C99 FMU of a compensator file: sources, binaries, and the description of the Python FMU."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import fmpy

from fmu_compensator.native.compilers import Compiler, c_files
from fmu_compensator.native.generate import constants, data_sources, program
from fmu_compensator.runtime.fmi_slave import MODEL_FILE
from fmu_compensator.runtime.modelfile import parse_model
from fmu_packaging.description import Program, described, model_description
from fmu_packaging.documentation import Running, index_page
from fmu_packaging.package import LICENCE, Package, Recipe, guid_of, slave_of
from fmu_packaging.slave import DriftSlave
from fmu_packaging.variables import Variable

HEADERS = Path(fmpy.__file__).parent / "c-code"
HOST = """
<p>C99 without Python: the host needs nothing but the C library. Binaries: {platforms}. For another
platform compile the folder <code>sources</code>: all files ending in <code>.c</code>, into one
shared library, with <code>-ffp-contract=off</code>; <code>fmpy compile</code> does it, too. No step
takes memory, and no two instances share any. Errors go to the host's log.</p>
"""
LICENCE_OF_HEADERS = "The FMI headers in <code>sources</code> are under the 2-clause BSD licence."
NO_OTHER_FILE = (
    "Must be empty: this FMU has its compensator file compiled in and reads no other. The Python "
    "FMU of the same file takes the path of another one here"
)


def native_package(
    recipe: Recipe, compilers: Sequence[Compiler], exchanged: Mapping[str, str] | None = None
) -> Package:
    """Return the C twin of a compensator FMU.

    Parameters
    ----------
    recipe : Recipe
        Of the Python FMU: identity, compensator file and page are taken from it.
    compilers : sequence of Compiler
        One binary is made with each.
    exchanged : dict of str to str, optional
        Sources that take the place of the program's, by path.

    Raises
    ------
    NativeError
        If the file or a variable has no counterpart in C.
    CompileError
        If a compiler refuses the sources.
    """
    name = recipe.identity.name
    slave = slave_of(recipe)
    sources = {**program(), "constants.h": constants(), **_headers(), **(exchanged or {})}
    twin = Program(
        "C99", needs_host=False, sources=_listed(sources), variables=_own_variables(slave)
    )
    variables = described(slave, twin)
    page = index_page(recipe.page, recipe.identity, variables, _running(compilers))
    files = {
        "model.png": recipe.icon,
        "documentation/index.html": page.encode(),
        "documentation/licenses/LICENSE.txt": LICENCE.read_bytes(),
        f"documentation/{MODEL_FILE}": recipe.data[MODEL_FILE],
    }

    def complete(guid: str) -> dict[str, str]:
        model = parse_model(recipe.data[MODEL_FILE].decode(), MODEL_FILE)
        files["modelDescription.xml"] = model_description(slave, recipe.identity, guid, twin)
        found = {**sources, "model_data.c": data_sources(model, variables, name, guid)}
        files.update({f"sources/{path}": text.encode() for path, text in found.items()})
        return found

    complete("")
    guid = guid_of(files)
    found = complete(guid)
    for compiler in compilers:
        path = f"binaries/{compiler.platform}/{name}{compiler.suffix}"
        files[path] = compiler.library(found)
    return Package(name, guid, files, slave)


def _headers() -> dict[str, str]:
    return {path.name: path.read_text("utf-8") for path in sorted(HEADERS.glob("fmi2*.h"))}


def _listed(sources: Mapping[str, str]) -> tuple[str, ...]:
    return tuple(sorted([*c_files(sources), "model_data.c"]))


def _own_variables(slave: DriftSlave) -> dict[str, Variable]:
    """Return what this FMU says otherwise of a variable than the Python FMU."""
    other = next(variable for variable in slave.variables if variable.is_parameter)
    return {other.name: replace(other, description=NO_OTHER_FILE)}


def _running(compilers: Sequence[Compiler]) -> Running:
    platforms = " and ".join(compiler.platform for compiler in compilers)
    return Running(HOST.format(platforms=platforms), LICENCE_OF_HEADERS)
