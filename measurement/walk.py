"""Finds classes in a folder, one per file, and in the entry points of a group."""

from __future__ import annotations

import inspect
from importlib import import_module
from pathlib import Path
from typing import TypeVar

from measurement.plugins import classes_plugged_in

T = TypeVar("T")


def classes_of(package: str, folder: Path, base: type[T], group: str = "") -> list[type[T]]:
    """Return the subclasses in a package's files, by file, then those of other distributions.

    Parameters
    ----------
    package : str
        Dotted name; its ``base`` module is skipped.
    folder : Path
        Folder of its files.
    base : type
        The base class.
    group : str
        Group of entry points; empty for none.

    Raises
    ------
    BadInput
        For a plug-in that is not such a class.
    """
    names = sorted(path.stem for path in folder.glob("[a-z]*.py"))
    modules = [import_module(f"{package}.{name}") for name in names if name != "base"]
    own = [
        thing
        for module in modules
        for thing in vars(module).values()
        if inspect.isclass(thing) and issubclass(thing, base) and thing is not base
    ]
    plugins = classes_plugged_in(group, base, names) if group else {}
    return [*own, *(plugin.thing for plugin in plugins.values())]
