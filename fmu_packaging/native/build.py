"""An FMU in C99: sources, binaries, and the description of its Python twin."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from html import escape
from pathlib import Path
from typing import Literal

import fmpy

from fmu_packaging.arrays import SOURCE, array_source, in_array
from fmu_packaging.bus_terminal import BusTerminal, SignalTerminal
from fmu_packaging.description import Program, described, model_description
from fmu_packaging.description3 import build_description, model_description3, terminals
from fmu_packaging.documentation import Running, index_page
from fmu_packaging.native.compilers import Compiler, c_files, in_one_file
from fmu_packaging.native.names import with_prefix
from fmu_packaging.package import LICENCE, Package, Recipe, guid_of, slave_of
from fmu_packaging.variables import Variable

Fmi = Literal[2, 3]
Part = Literal["sources", "binaries"]
HEADERS = Path(fmpy.__file__).parent / "c-code"
C_FOLDER = Path(__file__).resolve().parent / "c"
HOST = """
<p>C99 without Python: the host needs nothing but the C library. Binaries: {platforms}. {other}
No step takes memory, and no two instances share any. Errors go to the host's log. {note}</p>
"""
SOURCES = """For another platform compile the folder <code>sources</code>: all files ending in
<code>.c</code>, into one shared library, with <code>-ffp-contract=off</code>;
<code>fmpy compile</code> does it, too."""
NO_SOURCES = "The sources and the file that it was made from were left out."
TWIN_OF = "twin_of.txt"
"""File in the documentation of a C FMU: the GUID of the Python FMU with the same content."""
SIZES = """\
/* What an instance and a state of it take with NO_HEAP [bytes], as measured where pointers have
   eight bytes; with shorter ones it is less. */
#ifndef MEMORY_SIZE_H
#define MEMORY_SIZE_H

#define MEMORY_OF_INSTANCE {instance}
#define MEMORY_OF_STATE {state}

#endif
"""
LICENCE_OF_HEADERS = (
    "The FMI headers in <code>sources</code> are under the "
    "<a href='licenses/fmi_headers.txt'>2-clause BSD licence</a>."
)
CATEGORIES = {
    "logStatusDiscard": "Steps that were not made",
    "logStatusError": "Calls that were refused",
}
"""Categories of ``instance.c``."""

# fmpy's header of FMI 2.0 omits the standard's prefix; this restores it.
NO_PREFIX = """\
This definition has been changed to add no prefix.
*/
#define fmi2FullName(name) name
"""
PREFIX = """\
As in the standard, FMI2_FUNCTION_PREFIX stands before it where it is defined.
*/
#if defined(FMI2_FUNCTION_PREFIX)
  #define fmi2Paste(a, b)    a ## b
  #define fmi2PasteB(a, b)   fmi2Paste(a, b)
  #define fmi2FullName(name) fmi2PasteB(FMI2_FUNCTION_PREFIX, name)
#else
  #define fmi2FullName(name) name
#endif
"""


MEASURED = "memory_size.h"
MEASURE = Path(__file__).resolve().parent / "measure.c"
AMPLE_BYTES = 1 << 26
"""More bytes than any instance needs: set on no data."""


@dataclass(frozen=True)
class Native:
    """The ingredients of a C FMU, in addition to the shared front.

    Attributes
    ----------
    program : dict of str to str
        Sources that do not depend on the FMU's GUID, by path.
    data : callable
        Returns the sources that define the model, given its variables and its GUID.
    model_file : str
        The file among the recipe's data from which it was made.
    variables : dict of str to Variable
        Variables that differ from those of the Python FMU, and additional ones.
    documents : dict of str to bytes
        Further files of the documentation, by name.
    note : str
        A sentence on what it can or cannot be used for, or empty.
    bus : BusTerminal or SignalTerminal, optional
        The bus terminal that its program serves; FMI 3.0 only.
    derivatives : bool
        Whether its program provides derivatives.
    """

    program: Mapping[str, str]
    data: Callable[[Sequence[Variable], str], Mapping[str, str]]
    model_file: str
    variables: Mapping[str, Variable] = field(default_factory=dict)
    documents: Mapping[str, bytes] = field(default_factory=dict)
    note: str = ""
    bus: BusTerminal | SignalTerminal | None = None
    derivatives: bool = False


def front(fmi: Fmi) -> dict[str, str]:
    """Return the sources between FMI and any model, including headers, by path.

    Parameters
    ----------
    fmi : {2, 3}
    """
    other = f"fmi{5 - fmi}"
    paths = [*HEADERS.glob(f"fmi{fmi}*.h"), *C_FOLDER.glob("*.c"), *C_FOLDER.glob("*.h")]
    headers = {path.name: path.read_text("utf-8") for path in paths}
    return {
        name: text.replace(NO_PREFIX, PREFIX)
        for name, text in headers.items()
        if not name.startswith(other)
    }


def memory_size(sources: Mapping[str, str], compiler: Compiler, fmi: Fmi) -> str:
    """Return the header with the memory that an instance takes without a heap.

    Parameters
    ----------
    sources : dict of str to str
        Sources of the FMU, by path.
    compiler : Compiler
        For this machine, whose pointers are at least as long as any controller's.
    fmi : {2, 3}

    Raises
    ------
    CompileError
        If it refuses the sources, or the program does not run.
    """
    flags = ["NO_HEAP", f"MEMORY_OF_INSTANCE={AMPLE_BYTES}", f"MEMORY_OF_STATE={AMPLE_BYTES}"]
    flags += ["NO_HEAP_STATES=1", f"MEASURE_FMI{fmi}"]
    texts = {**sources, MEASURE.name: MEASURE.read_text("utf-8")}
    printed = compiler.printed(texts, [f"-D{flag}" for flag in flags])
    instance, state = map(int, printed.split())
    return SIZES.format(instance=instance, state=state)


def native_package(
    recipe: Recipe,
    native: Native,
    compilers: Sequence[Compiler],
    fmi: Fmi = 2,
    *,
    measured: bool = False,
    leave_out: Part | None = None,
    array: bool = False,
) -> Package:
    """Return the C twin of an FMU.

    Parameters
    ----------
    recipe : Recipe
        Recipe of the Python FMU, for identity, data and page.
    native : Native
    compilers : sequence of Compiler
        One binary is built with each.
    fmi : {2, 3}
        Version of FMI.
    measured : bool
        Whether the sources contain how much memory they take without a heap; one of the compilers
        must be for this machine.
    leave_out : {"sources", "binaries"}, optional
        Part to omit. Without sources, the file that it was made from is also omitted; without
        binaries, they are still used for its trial run.
    array : bool
        Whether the temperatures are one array; FMI 3.0 only.

    Raises
    ------
    CompileError
        If a compiler refuses the sources.
    NativeError
        If the temperatures cannot be an array.
    """
    identity, slave = recipe.identity, slave_of(recipe)
    fixed = {**front(fmi), **native.program}
    own, has = dict(native.variables), native.derivatives
    twin = Program("C99", False, (), own, CATEGORIES, native.bus, array, has)
    variables = described(slave, twin)
    shown = in_array(variables) if array else variables
    fixed |= {SOURCE: array_source(variables)} if array else {}
    sources = with_prefix({**fixed, **native.data(variables, "")}, fmi)
    if leave_out != "sources":
        twin = replace(twin, sources=tuple(c_files(sources)))
    if measured:
        here = next(entry for entry in compilers if entry.platform3 == fmpy.platform_tuple)
        fixed[MEASURED] = memory_size(sources, here, fmi)
    running = _running(compilers, fmi, leave_out, native.note)
    page = index_page(recipe.page, identity, shown, running)
    files = {
        "model.png" if fmi == 2 else "terminalsAndIcons/icon.png": recipe.icon,
        "documentation/index.html": page.encode(),
        "documentation/licenses/license.txt": LICENCE.read_bytes(),
        "documentation/licenses/fmi_headers.txt": _licence_of_headers(),
    }
    if leave_out != "sources":
        files[f"documentation/{native.model_file}"] = recipe.data[native.model_file]
    files |= {f"documentation/{name}": data for name, data in native.documents.items()}
    if fmi == 3:
        files["terminalsAndIcons/terminalsAndIcons.xml"] = terminals(slave, twin)
        files |= {} if native.bus is None else native.bus.files()
        if twin.sources:
            files["sources/buildDescription.xml"] = build_description(identity, twin)
    describe = model_description if fmi == 2 else model_description3

    def complete(guid: str) -> dict[str, str]:
        files["modelDescription.xml"] = describe(slave, identity, guid, twin)
        finished = with_prefix({**fixed, **native.data(variables, guid)}, fmi)
        if twin.sources:
            files.update({f"sources/{path}": text.encode() for path, text in finished.items()})
        return finished

    complete("")
    guid = guid_of(files)
    finished = complete(guid)
    binaries: dict[str, bytes] = {}
    for compiler in compilers:
        platform = compiler.platform if fmi == 2 else compiler.platform3
        path = f"binaries/{platform}/{identity.name}{compiler.suffix}"
        library = compiler.library(finished)
        binaries[path] = in_one_file(binaries[path], library) if path in binaries else library
    if leave_out == "binaries":
        return Package(identity.name, guid, files, slave, binaries, native.note)
    return Package(identity.name, guid, files | binaries, slave, note=native.note)


def _licence_of_headers() -> bytes:
    """Return the notice of the FMI headers, which binaries must also contain."""
    text = (HEADERS / "fmi3FunctionTypes.h").read_text("utf-8")
    begin, end = text.index("Copyright (C)"), text.rindex("-" * 70, 0, text.index("#ifdef"))
    return text[begin:end].rstrip("-\n").encode() + b"\n"


def _running(compilers: Sequence[Compiler], fmi: Fmi, leave_out: Part | None, note: str) -> Running:
    names = dict.fromkeys(compiler.platform3 for compiler in compilers)
    platforms = "none" if leave_out == "binaries" else ", ".join(names)
    other = NO_SOURCES if leave_out == "sources" else SOURCES
    host = HOST.format(platforms=platforms, other=other, note=escape(note))
    return Running(host, LICENCE_OF_HEADERS, f"{fmi}.0")
