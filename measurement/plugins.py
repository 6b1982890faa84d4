"""Plug-ins: effects, error models and importers that other installed distributions add.

A distribution names them by entry points (https://packaging.python.org/specifications/entry-points).
They are added to those in the project's folders. An unusable plug-in is refused in one line that
names distribution and entry point, since continuing without it would silently change results.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from functools import cache
from importlib.metadata import EntryPoint, entry_points
from typing import Any, Generic, TypeVar

from measurement.errors import BadInput

T = TypeVar("T")

EFFECTS = "spindle_drift.effects"
IMPORTERS = "spindle_drift.importers"


@dataclass(frozen=True)
class PlugIn(Generic[T]):
    """One entry point, loaded.

    Attributes
    ----------
    name : str
        Name of the entry point.
    source : str
        Entry point and distribution, for messages.
    group : str
    thing : object
        The loaded object.
    """

    name: str
    source: str
    group: str
    thing: T

    def refuse(self, problem: str) -> BadInput:
        """Return a refusal that names the plug-in.

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
        Names that the project itself uses.
    check : callable
        Returns what is wrong with a plug-in, or an empty string.

    Returns
    -------
    dict of str to PlugIn
        By the entry points' names.

    Raises
    ------
    BadInput
        For a plug-in that cannot be loaded, that `check` refuses, or whose name is taken.
    """
    return by_name(loaded(group), shipped, check)


def loaded(group: str) -> Iterator[PlugIn[Any]]:
    """Load the entry points of a group, one by one.

    Raises
    ------
    BadInput
        For the first one that cannot be loaded.
    """
    for point in _points(group):
        plugin = PlugIn(point.name, _source(point), group, None)
        with refusing(plugin):
            thing = point.load()
        yield replace(plugin, thing=thing)


@contextmanager
def refusing(plugin: PlugIn[Any]) -> Iterator[None]:
    """Refuse a plug-in whose code fails: third-party code may raise anything."""
    try:
        yield
    except (Exception, SystemExit) as error:
        problem = f"cannot be loaded: {type(error).__name__}: {error}; fix or uninstall it"
        raise plugin.refuse(problem) from None


def by_name(
    plugins: Iterable[PlugIn[T]], shipped: Collection[str], check: Callable[[PlugIn[T]], str]
) -> dict[str, PlugIn[T]]:
    """Return plug-ins by name.

    Raises
    ------
    BadInput
        For a plug-in whose name is taken, or that *check* refuses.
    """
    named: dict[str, PlugIn[T]] = {}
    for plugin in plugins:
        if plugin.name in shipped:
            raise plugin.refuse(f"{plugin.name} is a name that the project itself uses: rename it")
        if plugin.name in named:
            other = named[plugin.name].source
            raise plugin.refuse(f"{plugin.name} is a name that {other} also uses: uninstall one")
        if problem := check(plugin):
            raise plugin.refuse(problem)
        named[plugin.name] = plugin
    return named


def classes_plugged_in(
    group: str, base: type[T], shipped: Collection[str]
) -> dict[str, PlugIn[type[T]]]:
    """Load the entry points of a group, which must be subclasses of *base*.

    Parameters
    ----------
    group : str
    base : type
        An abstract class; a subclass must have all its methods.
    shipped : collection of str
        Names that the project itself uses.

    Returns
    -------
    dict of str to PlugIn
        By the entry points' names; each ``thing`` is the class.

    Raises
    ------
    BadInput
        As `plugged_in`, and for anything that is not such a subclass.
    """

    def check(plugin: PlugIn[Any]) -> str:
        kind = plugin.thing
        if not (isinstance(kind, type) and issubclass(kind, base)):
            return f"is no subclass of {base.__module__}.{base.__qualname__}"
        return lacking(kind)

    return plugged_in(group, shipped, check)


def lacking(kind: type[Any]) -> str:
    """Return a problem that names the methods a class leaves abstract; empty if there are none."""
    left = ", ".join(sorted(getattr(kind, "__abstractmethods__", ())))
    return f"{kind.__qualname__} lacks {left}" if left else ""


@cache
def _points(group: str) -> tuple[EntryPoint, ...]:
    """Return a group's entry points; one that is on the path twice counts once."""
    unique = {
        (point.name, point.value, _source(point)): point for point in entry_points(group=group)
    }
    return tuple(unique[key] for key in sorted(unique))


def _source(point: EntryPoint) -> str:
    made_by = f"{point.dist.name} {point.dist.version}" if point.dist else "an unknown distribution"
    return f"plug-in {point.name} of {made_by}"
