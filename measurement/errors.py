"""The error with which every reader refuses an input."""

from __future__ import annotations

import difflib
import math
import re
from collections.abc import Iterable
from pathlib import Path
from typing import Any, TypeVar

from pydantic import AfterValidator, BaseModel, ValidationError

M = TypeVar("M", bound=BaseModel)

MOST_LISTED = 30
"""Most names that a refusal lists, and most speed steps that a summary lists: set on no data."""


class BadInput(ValueError):  # noqa: N818 - what is bad is the input, not the program
    """An input that cannot be used.

    Its text is one line: where, what is wrong, and what is allowed.

    Parameters
    ----------
    source : path or str
        The file (or option) that holds the value.
    place : str
        Place in the source, for example ``row 12, column T1_degC`` or ``nodes.2.capacity``, which
        the text counts from one: see `counted_from_one`.
    problem : str
        What is wrong: the value and what is allowed.
    """

    def __init__(self, source: str | Path, place: str, problem: str) -> None:
        self.source, self.place, self.problem = str(source), place, problem
        # An option's value stays as it was typed.
        where = place if self.source.startswith("--") else counted_from_one(place)
        parts = [part for part in (self.source, where, problem) if part]
        super().__init__(": ".join(" ".join(part.split()) for part in parts))

    def __reduce__(self) -> tuple[type[BadInput], tuple[str, str, str]]:
        """Allow pickling, to pass the error from one process to another."""
        return type(self), (self.source, self.place, self.problem)


_PATH = r"[a-z]\w*(?:\.[^.\s]+)+"
"""Keys of a file, dotted; the name of a column or a sheet after another word is none."""


def counted_from_one(place: str) -> str:
    """Return a place in which items of lists are counted as people count.

    Parameters
    ----------
    place : str
        For example ``nodes.2.capacity``, which becomes ``nodes, item 3, capacity``.
    """
    if not re.fullmatch(rf"{_PATH}(?: \(.*\): {_PATH})?", place):
        return place
    counted = re.sub(r"\.(\d+)\b", lambda found: f", item {int(found[1]) + 1}", place)
    return re.sub(r"(, item \d+)\.", r"\1, ", counted)


def matching(pattern: str, words: str) -> AfterValidator:
    """Return the check that a whole text matches a pattern; the refusal says so in words.

    Parameters
    ----------
    pattern : str
        Regular expression.
    words : str
        What the text must be, for example "letters only".
    """

    def matched(text: str) -> str:
        if not re.fullmatch(pattern, text):
            raise ValueError(f"it must be {words}")
        return text

    return AfterValidator(matched)


def checked(kind: type[M], table: dict[str, Any], source: str | Path, within: str = "") -> M:
    """Return *table* as an instance of the pydantic model *kind*.

    Parameters
    ----------
    kind : type of pydantic model
    table : dict
        The parsed content; not modified.
    source : str or path
        The file, for the refusal.
    within : str
        Place of the table in the file.

    Raises
    ------
    BadInput
        For the first field that is missing, unknown, of the wrong type or out of range.
    """
    try:
        return kind.model_validate(table)
    except ValidationError as error:
        # With several mistakes, report the first one in the file.
        first, *others = error.errors(include_url=False)
    place = ".".join([within] * bool(within) + _steps(table, first))
    message = first["msg"].removeprefix("Value error, ")
    problem = message[0].lower() + message[1:]
    # A check of several fields together names them; its input is the whole table.
    if not (first["type"] == "value_error" and isinstance(first["input"], dict)):
        words = [other for other in others if other["type"] == "literal_error"]
        same = [other for other in words if _steps(table, other) == _steps(table, first)]
        problem = " or ".join([problem, *(other["ctx"]["expected"] for other in same)])
        problem = f"{shown(first['input'])} is not allowed: {problem}"
    problems = {"missing": "is missing", "extra_forbidden": "is not a known field"}
    problem = problems.get(first["type"], problem)
    beside = [
        str(other["loc"][-1])
        for other in others
        if (first["type"], other["type"]) == ("missing", "extra_forbidden")
        and other["loc"][:-1] == first["loc"][:-1]
    ]
    if beside:  # perhaps the same field, mistyped
        problem += f", and {beside[0]} is not a known field"
    raise BadInput(source, place, problem) from None


def _steps(table: Any, error: Any) -> list[str]:
    """Return the keys that lead to an error, without pydantic's names of alternatives."""
    steps = []
    for step in error["loc"]:
        try:
            table = table[step]
        except (KeyError, IndexError, TypeError):
            if error["type"] != "missing":
                continue
        steps.append(str(step))
    return steps


def one_of(source: str | Path, place: str, name: object, known: Iterable[str]) -> str:
    """Return the name if it is known.

    Parameters
    ----------
    source, place : path or str
        As `BadInput` takes them.
    name : object
        The value given.
    known : iterable of str

    Raises
    ------
    BadInput
        If it is not a string or not known; the text suggests the closest known name.
    """
    known = list(known)
    if isinstance(name, str) and name in known:
        return name
    listed = ", ".join(known[:MOST_LISTED]) or "them: there are none so far"
    listed += ", ..." if len(known) > MOST_LISTED else ""
    raise BadInput(source, place, f"{shown(name)} is not one of {listed}{near(name, known)}")


def refuse_other(source: str | Path, place: str, value: object, allowed: Iterable[str]) -> None:
    """Refuse a value that is none of a few, all of which the text lists.

    Parameters
    ----------
    source, place : path or str
        As `BadInput` takes them.
    value : object
        The value given.
    allowed : iterable of str

    Raises
    ------
    BadInput
        If the value is not one of them.
    """
    known = [*allowed]
    if value not in known:
        raise BadInput(source, place, f"{shown(value)} is not allowed: {', '.join(known)}")


def near(name: object, known: Iterable[str]) -> str:
    """Return the end of a refusal that suggests the name probably meant; empty if none is close."""
    close = difflib.get_close_matches(str(name), list(known), 1)
    return f"; did you mean {close[0]}?" if close else ""


def counted(count: int, word: str) -> str:
    """Return a count with its word, such as ``1 run`` or ``3 runs``."""
    return f"{count} {word}" if count == 1 else f"{count} {word}s"


def one_line(error: BaseException) -> str:
    """Return another library's error message in one line; the error's class if it has none."""
    return " ".join(str(error).split()) or type(error).__name__


def shown(value: object) -> str:
    """Return *value* as text for a refusal, cut to a readable length.

    Parameters
    ----------
    value : object
        Finite floats are shown with six digits, everything else as its ``repr``, cut at 60
        characters.
    """
    if isinstance(value, float) and math.isfinite(value):
        return f"{value:g}"
    text = repr(value)
    return text if len(text) <= 60 else text[:57] + "..."
