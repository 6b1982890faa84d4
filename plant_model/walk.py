"""Finds classes by walking a folder with one class per file."""

from __future__ import annotations

import importlib
import inspect
import pkgutil
from collections.abc import Iterable
from typing import TypeVar

T = TypeVar("T")


def classes_found(
    package: str, folder: Iterable[str], base: type[T], what: str
) -> dict[str, type[T]]:
    """Return the concrete subclass of *base* in each module of a package, by module name.

    Parameters
    ----------
    package : str
        The package's ``__name__``, which is different in a plant FMU.
    folder : iterable of str
        Its ``__path__``; the module ``base`` is skipped.
    base : type
        With a class attribute ``name``.
    what : str
        Folder and thing for the error message, for example ``effects effect``.

    Raises
    ------
    ImportError
        If a module does not hold exactly one class, or its name is not the file's.
    """
    place, thing = what.rsplit(" ", 1)
    classes_by_name: dict[str, type[T]] = {}
    for module in sorted(entry.name for entry in pkgutil.iter_modules(folder)):
        if module == "base":
            continue
        loaded = importlib.import_module(f"{package}.{module}")
        classes = [
            entry
            for entry in vars(loaded).values()
            if isinstance(entry, type) and issubclass(entry, base)
            if entry.__module__ == loaded.__name__ and not inspect.isabstract(entry)
        ]
        if len(classes) != 1 or getattr(classes[0], "name", None) != module:
            raise ImportError(f"{place}/{module}.py must hold one {thing}, and of the file's name")
        classes_by_name[module] = classes[0]
    return classes_by_name
