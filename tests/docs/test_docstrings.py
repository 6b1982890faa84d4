"""Docstrings of what crosses a border between packages: see Style in CONTRIBUTING.md."""

import ast
import importlib
import inspect
import re
from collections.abc import Iterator
from types import FunctionType
from typing import NamedTuple

import pytest

from measurement.units import UNITS
from tests.conftest import ROOMS, ROOT

NUMBERS = re.compile(r"^(?:float|FloatArray|Array)(?: \| None)?$")
BARE = {"value", "number", "low", "high", "off", "limit", "finer", "threshold", "theta"}
"""Names of numbers of any unit, or of none."""
UNIT = re.compile(r"\[[^\]]+\]")
UNIT_ENDINGS = tuple(
    f"_{suffix}" for suffix in (*UNITS, "K", "k", "C", "c", "h", "kW", "min", "share")
)


class Interface(NamedTuple):
    """A function or method that other packages call."""

    label: str
    function: FunctionType
    doc: str


def _trees() -> Iterator[tuple[str, ast.Module]]:
    for room in ROOMS:
        for path in sorted((ROOT / room).rglob("*.py")):
            name = ".".join(path.relative_to(ROOT).with_suffix("").parts)
            yield name.removesuffix(".__init__"), ast.parse(path.read_text("utf-8"))


def _package(module: str) -> str:
    path = ROOT / module.replace(".", "/")
    return module if path.is_dir() else module.rpartition(".")[0]


def _taken(tree: ast.Module) -> Iterator[tuple[str, object]]:
    """Give the modules of ours that a module imports from, each with what it uses of them."""
    for node in ast.walk(tree):
        if not isinstance(node, ast.ImportFrom) or not str(node.module).startswith(tuple(ROOMS)):
            continue
        module = importlib.import_module(str(node.module))
        for alias in node.names:
            found = getattr(module, alias.name, module)
            if not inspect.ismodule(found):
                yield module.__name__, found


def _functions(found: object) -> Iterator[Interface]:
    """Give a function, or what a class defines that no base class has."""
    found = inspect.unwrap(found)
    if inspect.isfunction(found):
        yield Interface(f"{found.__module__}.{found.__name__}", found, found.__doc__ or "")
    if not inspect.isclass(found):
        return
    known = {name for base in found.__mro__[1:] for name in vars(base)} - {"__init__"}
    known |= set(vars(found).get("__annotations__", ()))  # a field's default is no method
    for name, method in vars(found).items():
        method = inspect.unwrap(getattr(method, "__func__", method))
        made = getattr(getattr(method, "__code__", None), "co_filename", "<").startswith("<")
        if not made and name not in known and (name == "__init__" or not name.startswith("_")):
            doc = found.__doc__ if name == "__init__" else method.__doc__
            yield Interface(f"{found.__module__}.{found.__name__}.{name}", method, doc or "")


def _numbers(entry: Interface) -> list[str]:
    """Return the arguments that are numbers of some quantity and do not end in their unit."""
    return [
        name
        for name, argument in inspect.signature(entry.function).parameters.items()
        if NUMBERS.search(str(argument.annotation))
        and name not in BARE
        and not name.endswith(UNIT_ENDINGS)
    ]


def _lacks(entry: Interface) -> str:
    numbers = "" if UNIT.search(entry.doc) else ", ".join(_numbers(entry))
    return numbers and f"{entry.label} says no unit of {numbers}: [um], [K], [1] for a share"


@pytest.fixture(scope="module")
def interfaces() -> dict[str, Interface]:
    """What packages take from each other, by its name."""
    crossing = {
        id(found): found
        for module, tree in _trees()
        for source, found in _taken(tree)
        if _package(source) != _package(module) or module == "spindle_drift"
        if str(getattr(found, "__module__", "")).startswith(tuple(ROOMS))
    }
    return {entry.label: entry for found in crossing.values() for entry in _functions(found)}


def test_many_interfaces_are_found(interfaces):
    names = {"spindle_drift.gaps.find_gap", "plant_model.machine.Machine.with_values"}
    assert names <= set(interfaces)
    assert len(interfaces) > 400


@pytest.mark.parametrize("room", ROOMS)
def test_interfaces_say_the_units_of_what_they_take(interfaces, room):
    of_room = (e for e in interfaces.values() if e.label.partition(".")[0] == room)
    assert [lacks for entry in of_room if (lacks := _lacks(entry))] == []
