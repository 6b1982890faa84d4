"""The sources of a C FMU as a WebAssembly module, with a web page as its host.

The module exports the functions of FMI 3.0 and imports nothing. It also provides what FMI leaves to
the system: ``memory_take`` for the arrays that a host passes, and a logger (``web.c``).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any

from fmu_packaging.description import Program, described
from fmu_packaging.native.build import Native, front
from fmu_packaging.native.compilers import compiler_for_web
from fmu_packaging.native.names import with_prefix
from fmu_packaging.package import Recipe, slave_of
from fmu_packaging.variables import Variable

SHIM = Path(__file__).resolve().with_suffix(".c")
TOKEN = "web"


@dataclass(frozen=True)
class WebModule:
    """An FMU in WebAssembly: its sources by path, and its public variables by value reference."""

    sources: Mapping[str, str]
    variables: tuple[Variable, ...]

    @cached_property
    def code(self) -> bytes:
        """The module, compiled.

        Raises
        ------
        NativeError
            If the package ziglang is not installed.
        CompileError
            If it refuses the sources.
        """
        return compiler_for_web().library(self.sources)

    def told(self) -> dict[str, Any]:
        """Return what a page needs to call it, for JSON."""
        return {"token": TOKEN, "variables": [asdict(variable) for variable in self.variables]}


def web_module(recipe: Recipe, native: Native) -> WebModule:
    """Return the FMU of a recipe in WebAssembly.

    Parameters
    ----------
    recipe : Recipe
        Recipe of the Python FMU.
    native : Native

    Returns
    -------
    WebModule
        Not yet compiled.
    """
    variables = described(slave_of(recipe), Program("C99", False, variables=native.variables))
    sources = {**front(3), **native.program, **native.data(variables, TOKEN)}
    sources[SHIM.name] = SHIM.read_text("utf-8")
    shown = (replace(entry, depends=()) for entry in variables if entry.causality != "local")
    return WebModule(with_prefix(sources, 3), tuple(shown))
