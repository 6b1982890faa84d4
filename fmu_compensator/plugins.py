"""Error models from other installed distributions; a compensator FMU does not include this module.

An entry point names a module with one model, or a package in which each file is one model. A file
holds both the runtime class and the fitting class, or these are in files of the same name in the
package's folders ``runtime`` and ``fit``. Finding a runtime class does not import the fitting one.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator
from dataclasses import replace
from functools import cache
from importlib import import_module
from importlib.metadata import entry_points
from pkgutil import iter_modules
from types import ModuleType
from typing import TYPE_CHECKING, Any, TypeVar

from fmu_compensator.runtime.error_models.base import ErrorModel
from fmu_compensator.runtime.walk import class_in, classes_found

if TYPE_CHECKING:
    from measurement.plugins import PlugIn

GROUP = "spindle_drift.error_models"
RUNTIME, FIT = "runtime", "fit"
T = TypeVar("T")


@cache
def plugged_error_models(shipped: Collection[str]) -> dict[str, PlugIn[type[ErrorModel]]]:
    """Return the runtime error models of plug-ins, by kind.

    Parameters
    ----------
    shipped : frozenset of str
        Kinds that the project itself provides.

    Raises
    ------
    BadInput
        For a plug-in that is not an error model.
    """
    return plugged_classes(ErrorModel, RUNTIME, shipped)  # type: ignore[type-abstract]


def plugged_classes(
    base: type[T], half: str, shipped: Collection[str]
) -> dict[str, PlugIn[type[T]]]:
    """Return the subclasses of *base* in the files of plug-ins, by kind.

    Parameters
    ----------
    base : type
    half : {"runtime", "fit"}
        Folder of a package that is also searched.
    shipped : collection of str
        Kinds that the project itself provides.

    Raises
    ------
    BadInput
        For a plug-in that cannot be used, or whose kind already exists.
    """
    if not entry_points(group=GROUP):  # without plug-ins, the standard library suffices
        return {}
    from measurement.plugins import by_name, lacking, loaded

    every = (pair for plugin in loaded(GROUP) for pair in _in_files(plugin, base, half))
    return by_name(every, shipped, lambda plugin: lacking(plugin.thing))


def _in_files(plugin: PlugIn[Any], base: type[T], half: str) -> Iterator[PlugIn[type[T]]]:
    """Yield the classes of one entry point, named by their kinds."""
    from measurement.plugins import refusing

    module = plugin.thing
    if not isinstance(module, ModuleType):
        raise plugin.refuse("is no module or package: name the file and not the class in it")
    with refusing(plugin):
        classes = _classes(module, base, half)
    for name, kind in classes.items():
        for each in (name, *getattr(kind, "other_fits", ())):
            yield replace(plugin, name=each, thing=kind)


def _classes(module: ModuleType, base: type[T], half: str) -> dict[str, type[T]]:
    if not hasattr(module, "__path__"):
        kind = class_in(module, base)
        return {module.__name__.rpartition(".")[2]: kind} if kind else {}
    classes = classes_found(module.__name__, module.__path__, base)
    if any(info.name == half and info.ispkg for info in iter_modules(module.__path__)):
        folder = import_module(f"{module.__name__}.{half}")
        classes |= classes_found(folder.__name__, folder.__path__, base)
    return classes
