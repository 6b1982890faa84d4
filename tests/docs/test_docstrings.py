"""Docstrings of what crosses a border between packages: see Style in CONTRIBUTING.md."""

import ast
import importlib
import re
from collections.abc import Iterator
from functools import cache
from typing import NamedTuple

import pytest

from measurement.units import UNITS
from tests.conftest import ROOT

ROOMS = (
    "measurement",
    "fmu_packaging",
    "fmu_compensator",
    "plant_model",
    "studies",
    "scenarios",
    "gateway",
    "spindle_drift",
)
NO_INTERFACE = {"property", "cached_property", "setter", "overload"}
NUMBERS = re.compile(r"^(?:float|FloatArray|Array)(?: \| None)?$")
BARE = {"value", "number", "low", "high", "off", "limit", "finer", "threshold", "theta"}
"""Names of numbers of any unit, or of none."""
UNIT = re.compile(r"\[[^\]]+\]")
UNIT_ENDINGS = tuple(
    f"_{suffix}" for suffix in (*UNITS, "K", "k", "C", "c", "h", "kW", "min", "share")
)

Definition = ast.FunctionDef | ast.ClassDef


class Place(NamedTuple):
    """A name of a module."""

    module: str
    name: str


@cache
def _modules() -> dict[str, ast.Module]:
    found = {}
    for room in ROOMS:
        for path in sorted((ROOT / room).rglob("*.py")):
            parts = path.relative_to(ROOT).with_suffix("").parts
            found[".".join(parts).removesuffix(".__init__")] = ast.parse(path.read_text("utf-8"))
    return found


def _package(module: str) -> str:
    path = ROOT / module.replace(".", "/")
    return module if path.is_dir() else module.rpartition(".")[0]


def _taken(importer: str, tree: ast.Module) -> Iterator[Place]:
    """Give the names of other modules that a module uses."""
    for node in ast.walk(tree):
        if not isinstance(node, ast.ImportFrom) or node.module not in _modules():
            continue
        for alias in node.names:
            inner = f"{node.module}.{alias.name}"
            if inner not in _modules():
                yield Place(node.module, alias.name)
                continue
            attributes = (use for use in ast.walk(tree) if isinstance(use, ast.Attribute))
            for use in attributes:
                if ast.unparse(use.value) == (alias.asname or alias.name):
                    yield Place(inner, use.attr)


def _defined(place: Place) -> tuple[str, Definition] | None:
    """Return where a name is defined, through modules that hand it on; None for a plain value."""
    for node in _modules()[place.module].body:
        if isinstance(node, ast.FunctionDef | ast.ClassDef) and node.name == place.name:
            return place.module, node
        if isinstance(node, ast.ImportFrom) and node.module in _modules():
            for alias in node.names:
                if (alias.asname or alias.name) == place.name:
                    return _defined(Place(node.module, alias.name))
    return None


def _bases(module: str, node: ast.ClassDef) -> Iterator[ast.ClassDef]:
    for base in node.bases:
        name = base.value if isinstance(base, ast.Subscript) else base
        found = _defined(Place(module, name.id)) if isinstance(name, ast.Name) else None
        if found is not None and isinstance(found[1], ast.ClassDef):
            yield found[1]
            yield from _bases(found[0], found[1])


def _of_libraries(module: str, node: ast.ClassDef) -> set[str]:
    """Return the methods that a class has from a base class of somebody else."""
    bases = getattr(importlib.import_module(module), node.name).__mro__
    foreign = [base for base in bases if base.__module__.partition(".")[0] not in ROOMS]
    return {name for base in foreign for name in vars(base)}


def _methods(node: ast.ClassDef) -> dict[str, ast.FunctionDef]:
    return {entry.name: entry for entry in node.body if isinstance(entry, ast.FunctionDef)}


class Interface(NamedTuple):
    """A function or method that other packages call."""

    label: str
    function: ast.FunctionDef
    doc: str
    arguments: list[ast.arg]


def _arguments(function: ast.FunctionDef, *, bound: bool) -> list[ast.arg]:
    given = function.args
    found = [*given.posonlyargs, *given.args]
    found = found[1:] if bound else found
    starred = [entry for entry in (given.vararg, given.kwarg) if entry is not None]
    return [*found, *given.kwonlyargs, *starred]


def _decorators(function: ast.FunctionDef) -> set[str]:
    return {ast.unparse(entry).rpartition(".")[2] for entry in function.decorator_list}


def _of_class(module: str, node: ast.ClassDef) -> Iterator[Interface]:
    described = {name for base in _bases(module, node) for name in _methods(base)}
    described |= _of_libraries(module, node)
    for name, method in _methods(node).items():
        if name != "__init__" and (name.startswith("_") or name in described):
            continue
        decorators = _decorators(method)
        if decorators & NO_INTERFACE:
            continue
        doc = ast.get_docstring(node if name == "__init__" else method) or ""
        arguments = _arguments(method, bound="staticmethod" not in decorators)
        yield Interface(f"{module}.{node.name}.{name}", method, doc, arguments)


def _interfaces() -> Iterator[Interface]:
    places = {
        place
        for module, tree in _modules().items()
        for place in _taken(module, tree)
        if _package(place.module) != _package(module) or module == "spindle_drift"
    }
    seen = set()
    for place in sorted(places):
        found = _defined(place)
        if found is None or (found[0], found[1].name) in seen:
            continue
        module, node = found
        seen.add((module, node.name))
        if isinstance(node, ast.ClassDef):
            yield from _of_class(module, node)
        else:
            doc, arguments = ast.get_docstring(node) or "", _arguments(node, bound=False)
            yield Interface(f"{module}.{node.name}", node, doc, arguments)


def _numbers(entry: Interface) -> list[str]:
    """Return the arguments that are numbers of some quantity and do not end in their unit."""
    return [
        argument.arg
        for argument in entry.arguments
        if argument.annotation is not None
        and NUMBERS.search(ast.unparse(argument.annotation))
        and argument.arg not in BARE
        and not argument.arg.endswith(UNIT_ENDINGS)
    ]


def _lacks(entry: Interface) -> Iterator[str]:
    if not entry.doc:
        yield "has no docstring"
    elif (numbers := _numbers(entry)) and not UNIT.search(entry.doc):
        yield f"says no unit of {', '.join(numbers)}: [um], [K], [1] for a share or a count"


@pytest.fixture(scope="module")
def interfaces() -> list[Interface]:
    return list(_interfaces())


def test_many_interfaces_are_found(interfaces):
    labels = {entry.label for entry in interfaces}
    assert {"spindle_drift.gaps.find_gap", "plant_model.machine.Machine.with_values"} <= labels
    assert len(labels) > 400


@pytest.mark.parametrize("room", ROOMS)
def test_interfaces_say_the_units_of_what_they_take(interfaces, room):
    lacking = [
        f"{entry.label} {problem}"
        for entry in interfaces
        if entry.label.partition(".")[0] == room
        for problem in _lacks(entry)
    ]
    assert not lacking, "\n".join(lacking)
