"""Plug-ins: effects, error models and importers that other installed distributions add.

A distribution names them by entry points (https://packaging.python.org/specifications/entry-points).
They are found together with what the folders of the project hold. One that cannot be used is
refused in one line that names distribution and entry point: to go on without it would change
results and say nothing.
"""

from __future__ import annotations

from collections.abc import Callable, Collection
from dataclasses import dataclass
from functools import cache
from importlib.metadata import EntryPoint, entry_points
from typing import Any, Generic, TypeVar

from measurement.errors import BadInput

T = TypeVar("T")

EFFECTS = "spindle_drift.effects"
FITTED_ERROR_MODELS = "spindle_drift.fitted_error_models"
IMPORTERS = "spindle_drift.importers"


@dataclass(frozen=True)
class PlugIn(Generic[T]):
    """One entry point, loaded.

    Attributes
    ----------
    name : str
        Of the entry point.
    source : str
        How a message names it: entry point and distribution.
    group : str
    thing : object
        What it stands for.
    """

    name: str
    source: str
    group: str
    thing: T

    def refuse(self, problem: str) -> BadInput:
        """Return a refusal that names it.

        Parameters
        ----------
        problem : str
            What is wrong with it, and what to do.
        """
        return BadInput(self.source, self.group, problem)


def plugged_in(
    group: str, shipped: Collection[str], check: Callable[[PlugIn[Any]], str]
) -> dict[str, PlugIn[Any]]:
    """Load the entry points of a group.

    Parameters
    ----------
    group : str
    shipped : collection of str
        Names that the project itself has.
    check : callable
        Returns what is wrong with a plug-in, or nothing.

    Returns
    -------
    dict of str to PlugIn
        By the entry points' names.

    Raises
    ------
    BadInput
        For a plug-in that cannot be loaded, that `check` refuses, or whose name is taken.
    """
    found: dict[str, PlugIn[Any]] = {}
    for point in _points(group):
        source = _source(point)
        try:
            plugin = PlugIn(point.name, source, group, point.load())
        except (Exception, SystemExit) as error:  # a stranger's module may raise anything
            problem = f"cannot be loaded: {type(error).__name__}: {error}; mend or uninstall it"
            raise BadInput(source, group, problem) from None
        if point.name in shipped:
            raise plugin.refuse(f"{point.name} is a name that the project itself has: rename it")
        if point.name in found:
            raise plugin.refuse(f"has the name of {found[point.name].source}: uninstall one")
        problem = check(plugin)
        if problem:
            raise plugin.refuse(problem)
        found[point.name] = plugin
    return found


def classes_plugged_in(
    group: str, base: type[T], shipped: Collection[str]
) -> dict[str, PlugIn[type[T]]]:
    """Load the entry points of a group that stand for subclasses of *base*.

    Parameters
    ----------
    group : str
    base : type
        An abstract class; a subclass must have all its methods.
    shipped : collection of str
        Names that the project itself has.

    Returns
    -------
    dict of str to PlugIn
        By the entry points' names; the thing of each is the class.

    Raises
    ------
    BadInput
        As `plugged_in`, and for anything but a subclass.
    """

    def check(plugin: PlugIn[Any]) -> str:
        kind = plugin.thing
        if not (isinstance(kind, type) and issubclass(kind, base)):
            return f"is no subclass of {base.__module__}.{base.__qualname__}"
        left = ", ".join(sorted(getattr(kind, "__abstractmethods__", ())))
        return f"{kind.__qualname__} lacks {left}" if left else ""

    return plugged_in(group, shipped, check)


@cache
def _points(group: str) -> tuple[EntryPoint, ...]:
    """Return a group's entry points; one that lies on the path twice counts once."""
    unique = {
        (point.name, point.value, _source(point)): point for point in entry_points(group=group)
    }
    return tuple(unique[key] for key in sorted(unique))


def _source(point: EntryPoint) -> str:
    made_by = f"{point.dist.name} {point.dist.version}" if point.dist else "an unknown distribution"
    return f"plug-in {point.name} of {made_by}"
