"""Find the variants of a class by walking the folder that holds them."""

from __future__ import annotations

import importlib
import pkgutil
from collections.abc import Iterable
from types import ModuleType
from typing import TypeVar

T = TypeVar("T")


def classes_found(package: str, folder: Iterable[str], base: type[T]) -> dict[str, type[T]]:
    """Return the subclass of *base* that each module of a package defines, by module name.

    Parameters
    ----------
    package : str
        The package's ``__name__``, which differs if the package is bundled under another root.
    folder : iterable of str
        The package's ``__path__``.
    base : type
        Other classes, and modules without a subclass of it, are ignored.

    Raises
    ------
    TypeError
        If a module defines two of them: each file is one variant.
    """
    classes: dict[str, type[T]] = {}
    for name in sorted(info.name for info in pkgutil.iter_modules(list(folder)) if not info.ispkg):
        kind = class_in(importlib.import_module(f"{package}.{name}"), base)
        if kind is not None:
            classes[name] = kind
    return classes


def class_in(module: ModuleType, base: type[T]) -> type[T] | None:
    """Return the subclass of *base* that a module itself defines; None if it has none.

    Raises
    ------
    TypeError
        If it defines two of them.
    """
    own = [
        thing
        for thing in vars(module).values()
        if isinstance(thing, type)
        and issubclass(thing, base)
        and thing is not base
        and thing.__module__ == module.__name__
    ]
    if len(own) > 1:
        raise TypeError(f"{module.__name__} defines {len(own)} variants, one is allowed")
    return own[0] if own else None
