"""Refuses arguments of the wrong type in one line, before the function begins."""

from __future__ import annotations

import collections.abc as abc
import inspect
import numbers
import os
import types
from collections.abc import Callable
from functools import cache, wraps
from pathlib import Path
from typing import Any, Literal, ParamSpec, TypeVar, Union, get_args, get_origin, get_type_hints

from fmu_compensator.fit.error_models.options import refuse_unknown
from measurement.errors import BadInput, shown
from scenarios.arguments import entries

P = ParamSpec("P")
R = TypeVar("R")
T = TypeVar("T")

KINDS = {int: numbers.Integral, float: numbers.Real, Path: os.PathLike}
"""What also passes for a type: numpy's numbers, any path-like object."""


def refusing(function: Callable[P, R]) -> Callable[P, R]:
    """Let a function of the API refuse arguments that do not match its annotations.

    The refusal quotes the type in the docstring. Any iterable passes as a sequence; the items of an
    iterator are not checked.
    """
    signature = inspect.signature(function)

    @wraps(function)
    def refuses(*args: P.args, **kwargs: P.kwargs) -> R:
        try:
            given = signature.bind_partial(*args, **kwargs).arguments
        except TypeError:  # too many arguments: Python's own error names the function
            return function(*args, **kwargs)
        _refuse_types(function, given, _name(function))
        return function(*args, **kwargs)

    return refuses


def refusing_methods(kind: type[T]) -> type[T]:
    """Let the public methods of a class refuse, as `refusing` does.

    The constructor too if the class docstring has parameters. Results, which have attributes only,
    are made by this package alone.
    """
    checked = {"__init__"} if "Parameters\n" in (kind.__doc__ or "") else set()
    for name, thing in list(vars(kind).items()):
        if inspect.isfunction(thing) and (name in checked or not name.startswith("_")):
            setattr(kind, name, refusing(thing))
        elif isinstance(thing, classmethod):
            setattr(kind, name, classmethod(refusing(thing.__func__)))
    return kind


def refuse_options(
    function: Callable[..., Any], options: abc.Mapping[str, Any], name: str, *, rest: bool = False
) -> None:
    """Refuse options passed on to a function that it does not have, or has with another type.

    Parameters
    ----------
    function : callable
        Its keyword-only parameters are the options.
    options : mapping
        The options given.
    name : str
        What the options were given to, for the refusal.
    rest : bool
        Whether the function passes on options that it does not have.

    Raises
    ------
    BadInput
        Names the first such option.
    """
    if not rest:
        refuse_unknown(name, options, function)
    _refuse_types(function, options, name)


def _refuse_types(function: Callable[..., Any], given: abc.Mapping[str, Any], name: str) -> None:
    """Refuse the first argument, in order of parameters, that is not of its type."""
    for key, kind in parameter_types(function).items():
        if key in given and not _is(value := given[key], kind):
            problem = f"{shown(value)} is not allowed: {_words(function, key)} is needed"
            raise BadInput(name, key, problem)


@cache
def parameter_types(function: Callable[..., Any]) -> dict[str, Any]:
    """Return the types of a function's parameters by name."""
    from spindle_drift.machines import Machine

    parameters = inspect.signature(function).parameters.values()
    said = {
        entry.name: entry.annotation
        for entry in parameters
        if entry.annotation is not entry.empty and entry.kind is not entry.VAR_KEYWORD
    }
    annotated = types.SimpleNamespace(__annotations__=said)
    return get_type_hints(annotated, inspect.unwrap(function).__globals__, {"Machine": Machine})


def _is(value: object, hint: Any) -> bool:
    """Return whether a value is of a type."""
    origin, inner = get_origin(hint), get_args(hint)
    if hint is Any:
        return True
    if origin in (Union, types.UnionType):
        return any(_is(value, kind) for kind in inner)
    if origin is Literal:
        return value in inner
    if origin is abc.Callable:
        return callable(value)
    if origin in (abc.Mapping, abc.Sequence, tuple):
        return _holds(value, origin, inner)
    if isinstance(value, bool):
        return hint in (bool, object)
    return isinstance(value, (hint, KINDS.get(hint, hint)))


def _holds(value: object, origin: Any, inner: tuple[Any, ...]) -> bool:
    """Return whether a value is a container whose items are of the wanted types."""
    if origin is abc.Mapping:
        return isinstance(value, abc.Mapping) and all(
            _is(key, inner[0]) and _is(held, inner[1]) for key, held in value.items()
        )
    if isinstance(value, (str, bytes, abc.Mapping)) or not isinstance(value, abc.Iterable):
        return False
    parts = () if isinstance(value, abc.Iterator) else tuple(value)
    fits = origin is not tuple or ... in inner or len(parts) == len(inner)
    return fits and all(_is(part, inner[0]) for part in parts)


def _name(function: Callable[..., Any]) -> str:
    return function.__qualname__.removesuffix(".__init__")


def _words(function: Callable[..., Any], name: str) -> str:
    """Return the type of a parameter as its docstring gives it."""
    described = entries(function)
    if function.__name__ == "__init__":
        module = inspect.getmodule(function)
        described = entries(getattr(module, _name(function)))
    return described[name][0].removesuffix(", optional")
