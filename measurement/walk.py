"""Classes that a folder of files and the entry points of a group hold: one file, one more."""

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
        Dotted name; its ``base`` module is not looked at.
    folder : Path
        Where its files are.
    base : type
        What they derive from.
    group : str
        Of entry points; none where it is empty.

    Raises
    ------
    BadInput
        For a plug-in that is no such class.
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
