"""The C99 FMU of a compensator file: sources, binaries, and the description of the Python FMU."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Literal

import fmpy

from fmu_compensator.native.compilers import Compiler, c_files
from fmu_compensator.native.generate import constants, data_sources, program
from fmu_compensator.runtime.fmi_slave import MODEL_FILE
from fmu_compensator.runtime.modelfile import parse_model
from fmu_packaging.description import Program, described, model_description
from fmu_packaging.description3 import build_description, model_description3
from fmu_packaging.documentation import Running, index_page
from fmu_packaging.package import LICENCE, Package, Recipe, guid_of, slave_of
from fmu_packaging.slave import DriftSlave
from fmu_packaging.variables import Variable

Fmi = Literal[2, 3]
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
    recipe: Recipe,
    compilers: Sequence[Compiler],
    fmi: Fmi = 2,
    exchanged: Mapping[str, str] | None = None,
) -> Package:
    """Return the C twin of a compensator FMU.

    Parameters
    ----------
    recipe : Recipe
        Of the Python FMU: identity, compensator file and page are taken from it.
    compilers : sequence of Compiler
        One binary is made with each.
    fmi : {2, 3}
        Version of FMI.
    exchanged : dict of str to str, optional
        Sources that take the place of the program's, by path.

    Raises
    ------
    NativeError
        If the file or a variable has no counterpart in C.
    CompileError
        If a compiler refuses the sources.
    """
    identity, slave = recipe.identity, slave_of(recipe)
    sources = {**shared_sources(fmi), **(exchanged or {})}
    twin = Program(
        "C99", needs_host=False, sources=_listed(sources), variables=_own_variables(slave)
    )
    variables = described(slave, twin)
    model = parse_model(recipe.data[MODEL_FILE].decode(), MODEL_FILE)
    page = index_page(recipe.page, identity, variables, _running(compilers, fmi))
    files = {
        "model.png": recipe.icon,
        "documentation/index.html": page.encode(),
        "documentation/licenses/LICENSE.txt": LICENCE.read_bytes(),
        f"documentation/{MODEL_FILE}": recipe.data[MODEL_FILE],
    }
    if fmi == 3:
        files["sources/buildDescription.xml"] = build_description(identity, twin)
    describe = model_description if fmi == 2 else model_description3

    def complete(guid: str) -> dict[str, str]:
        files["modelDescription.xml"] = describe(slave, identity, guid, twin)
        found = {**sources, "model_data.c": data_sources(model, variables, identity.name, guid)}
        files.update({f"sources/{path}": text.encode() for path, text in found.items()})
        return found

    complete("")
    guid = guid_of(files)
    found = complete(guid)
    for compiler in compilers:
        platform = compiler.platform if fmi == 2 else compiler.platform3
        path = f"binaries/{platform}/{identity.name}{compiler.suffix}"
        files[path] = compiler.library(found)
    return Package(identity.name, guid, files, slave)


def shared_sources(fmi: Fmi) -> dict[str, str]:
    """Return the sources of every compensator for a version of FMI, headers included, by path."""
    front = f"fmi{fmi}"
    headers = {path.name: path.read_text("utf-8") for path in HEADERS.glob(f"{front}*.h")}
    chosen = {
        path: text
        for path, text in program().items()
        if path.startswith(front) or not path.startswith("fmi")
    }
    return {**chosen, **headers, "constants.h": constants()}


def _listed(sources: Mapping[str, str]) -> tuple[str, ...]:
    return tuple(sorted([*c_files(sources), "model_data.c"]))


def _own_variables(slave: DriftSlave) -> dict[str, Variable]:
    """Return what this FMU says otherwise of a variable than the Python FMU."""
    other = next(variable for variable in slave.variables if variable.is_parameter)
    return {other.name: replace(other, description=NO_OTHER_FILE)}


def _running(compilers: Sequence[Compiler], fmi: Fmi) -> Running:
    platforms = " and ".join(compiler.platform for compiler in compilers)
    return Running(HOST.format(platforms=platforms), LICENCE_OF_HEADERS, f"{fmi}.0")
