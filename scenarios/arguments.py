"""Makes a command's arguments from a function of the Python API, so that each is defined once.

The type comes from the annotation, the default from the signature, and the help text from the
parameter's entry in the docstring.
"""

from __future__ import annotations

import argparse
import ast
import inspect
import json
import re
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from measurement.naming import lowered

KINDS: dict[str, dict[str, Any]] = {
    "bool": {"action": "store_true"},
    "int": {"type": int},
    "float": {"type": float},
    "Sequence[str]": {"nargs": "+"},
    "tuple[float, float]": {"nargs": 2, "type": float},
    "tuple[str, ...]": {"action": "append", "default": []},
    "Path": {"type": Path, "metavar": "FILE"},
    "str | Path": {"metavar": "FILE"},
}
"""Options for argparse by annotation; an argument of any other annotation is one word."""
UNITS = {"s": "SECONDS", "mm": "MM", "k": "K"}
"""Placeholder of a number whose parameter's name ends in its unit; the option's name omits it."""
DIRECTORY = {"type": Path, "metavar": "DIR"}
ENTRY = re.compile(r"^(\w[\w, ]*?) : (.*)\n?((?:[ ]{4}.*\n?)*)", re.MULTILINE)
"""An entry for parameters in a docstring: names, type, text."""


def add_parameters(
    parser: argparse._ActionsContainer,
    function: Callable[..., Any],
    *names: str,
    **changes: Mapping[str, Any],
) -> None:
    """Declare arguments for some of a function's parameters, or of a dataclass's fields.

    Parameters
    ----------
    parser : ArgumentParser or a group of one
    function : callable
        With a numpydoc docstring.
    *names : str
        Parameters to declare unchanged: ``noise_seed`` is ``--noise-seed``, ``every_s`` is
        ``--every SECONDS``, and one without a default is a required positional argument.
    **changes : mapping
        Parameters whose option differs: the keywords for `argparse`, by name; ``flag`` is the
        option's name, or a tuple of its names.
    """
    described = entries(function)
    signature = inspect.signature(function).parameters
    for name, change in {**{key: {} for key in names}, **changes}.items():
        parameter, (kind, text) = signature[name], described[name]
        stem, _, unit = name.rpartition("_")
        argument: dict[str, Any] = {"default": parameter.default, "help": text}
        argument |= KINDS.get(str(parameter.annotation).removesuffix(" | None"), {})
        argument |= {"metavar": UNITS[unit]} if unit in UNITS else {}
        option = (stem if unit in UNITS else name).replace("_", "-")
        if parameter.default is parameter.empty and "flag" not in change:
            flag, argument["default"], argument["metavar"] = name, None, name.upper()
        else:
            flag, argument["dest"] = f"--{option}", name
        argument |= change
        if isinstance(argument.get("metavar"), str):
            argument["help"] = argument["help"].replace(f" [{unit}]", "")
        if re.fullmatch(r"\{[^}]*\}(, optional)?", kind) and "metavar" not in argument:
            choices = ast.literal_eval(f"[{kind[1 : kind.index('}')]}]")
            argument |= {"choices": choices, "type": type(choices[0])}
        if argument["default"] is parameter.empty:
            argument["default"] = None
        if argument["default"] and "default" not in argument["help"]:
            argument["help"] += " (default: %(default)s)"
        if argument.get("action") == "append":
            argument["help"] += "; may be repeated"
        flags = argument.pop("flag", flag)
        parser.add_argument(*([flags] if isinstance(flags, str) else flags), **argument)


def parameters_of(
    args: argparse.Namespace, function: Callable[..., Any], *names: str
) -> dict[str, Any]:
    """Return the command line's values of a function's parameters, all of them or *names*."""
    wanted = names or tuple(inspect.signature(function).parameters)
    return {name: getattr(args, name) for name in wanted if hasattr(args, name)}


def defaults(function: Callable[..., Any]) -> dict[str, Any]:
    """Return the defaults of a function's parameters by name."""
    parameters = inspect.signature(function).parameters.items()
    return {name: entry.default for name, entry in parameters if entry.default is not entry.empty}


def entries(function: Callable[..., Any]) -> dict[str, tuple[str, str]]:
    """Return each parameter's type and help text, by name."""
    options = {}
    for names, kind, text in ENTRY.findall(inspect.getdoc(function) or ""):
        words = re.sub(r"``|`|\*(\w+)\*", r"\1", " ".join(text.split()))
        shown = lowered(words).rstrip(".").replace("%", "%%")
        for name in names.split(", "):
            options[name] = (kind, shown)
    return options


def add_runs(parser: argparse.ArgumentParser, text: str = "run file (CSV)") -> None:
    """Declare the runs that a command reads."""
    parser.add_argument("runs", nargs="+", type=Path, metavar="RUN", help=text)


def add_output(
    parser: argparse.ArgumentParser, text: str, *, metavar: str = "FILE", default: str = ""
) -> None:
    """Declare the file or folder that a command writes; required if there is no default."""
    usual = {"default": Path(default)} if default else {"required": True}
    parser.add_argument(
        "-o",
        "--output",
        type=Path,
        metavar=metavar,
        help=text + (f" ({default})" if default else ""),
        **usual,
    )


def add_results(parser: argparse.ArgumentParser, text: str, **more: Any) -> None:
    """Declare the folder of results."""
    parser.add_argument("--out", type=Path, metavar="DIR", help=text, **more)


def add_json(parser: argparse.ArgumentParser, text: str = "print JSON instead of text") -> None:
    """Declare ``--json``, for output that programs read."""
    parser.add_argument("--json", action="store_true", help=text)


def tell(args: argparse.Namespace, table: object, *lines: str) -> int:
    """Print the result as JSON or, unless ``--quiet`` is given, as text; return 0.

    Parameters
    ----------
    args : Namespace
        With ``json``, and perhaps ``quiet``.
    table : object
        The result, ready for JSON.
    *lines : str
        The same as text.
    """
    if args.json:
        print(json.dumps(table, indent=1, ensure_ascii=False))
    elif not getattr(args, "quiet", False):
        print(*lines, sep="\n")
    return 0
