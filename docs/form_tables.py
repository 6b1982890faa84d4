"""Tables of the fields that a file may have, from the forms that check it."""

from __future__ import annotations

import ast
import inspect
import re
import textwrap
from collections.abc import Container, Iterable, Iterator, Mapping
from types import NoneType, UnionType
from typing import Annotated, Any, Literal, Union, get_args, get_origin

from annotated_types import Ge, Gt, Le
from pydantic import AfterValidator, BaseModel
from pydantic.fields import FieldInfo

from plant_model.drawing.form import Quantity

Row = list[str]
SECTION = re.compile(r"^(?:Attributes|Parameters)\n-+\n(.*?)(?=^\w[^\n]*\n-+\n|\Z)", re.M | re.S)
NO_BOUND = 1e8
"""A range that ends there or later keeps out slips of the keyboard and is not shown."""
NUMBERS = {int: "a whole number", float: "a number"}
MANY: Mapping[Any, str] = {dict: "a table of names: ", list: "a list: "}
WORDS = {str: "text", bool: "true or false", Any: "a table", dict: "a table"}


def meanings(form: type) -> dict[str, str]:
    """Return what is said of a class's attributes: below them, or in its docstring's list."""
    found: dict[str, str] = {}
    for base in reversed(form.__mro__):
        if base.__module__.partition(".")[0] not in ("pydantic", "builtins", "abc"):
            found |= dict(_listed(inspect.cleandoc(base.__doc__ or "")))
            found |= dict(_below(base))
    return found


def _listed(text: str) -> Iterator[tuple[str, str]]:
    for section in SECTION.findall(text):
        entry = re.compile(r"^(\w[^\n]*?) : [^\n]*\n((?:[ ]+[^\n]*\n?|\n)+)", re.M)
        for names, told in entry.findall(section):
            for name in names.split(", "):
                yield name, plain(told)


def _below(form: type) -> Iterator[tuple[str, str]]:
    tree = ast.parse(textwrap.dedent(inspect.getsource(form))).body[0]
    assert isinstance(tree, ast.ClassDef)
    for field, after in zip(tree.body, tree.body[1:], strict=False):
        if isinstance(field, ast.AnnAssign) and isinstance(after, ast.Expr):
            assert isinstance(field.target, ast.Name)
            assert isinstance(after.value, ast.Constant)
            yield field.target.id, plain(after.value.value)


def plain(text: str) -> str:
    """Return a docstring's text as Markdown on one line."""
    line = " ".join(text.split()).replace("``", "`")
    line = re.sub(r"(?<!\w)\*(\w+)\*(?!\w)", r"`\1`", line)
    return line.removesuffix(".")


def rows(form: type[BaseModel], place: str = "", without: Container[str] = ()) -> Iterator[Row]:
    """Return a row for each field of a form and of the forms in it: place, allowed, default, text.

    Parameters
    ----------
    form : type
        A pydantic model.
    place : str
        Where it stands in the file, with a dot at the end.
    without : container of str
        Fields of the outermost form that are left out.
    """
    told, inner = meanings(form), []
    for name, info in form.model_fields.items():
        if name in without:
            continue
        key = info.alias or name
        kinds = list(_kinds(info.annotation))
        forms = [kind for kind in kinds if isinstance(kind, type) and _is_form(kind)]
        origin = get_origin(info.annotation)
        many = {list: "[]", dict: ".NAME"}.get(origin, "")
        inner += [(one, f"{place}{key}{many}.") for one in forms]
        if not forms or told.get(name):
            allowed = "a table" if forms else _allowed(info)
            yield [f"`{place}{key}`", allowed, _default(info), told.get(name, "")]
    for one, deeper in inner:
        yield from rows(one, deeper)


def merged(found: Iterable[Row]) -> list[Row]:
    """Return rows with neighbours that differ by their name alone, or by nothing, as one."""
    together: list[Row] = []
    for row in found:
        if together and together[-1][1:] == row[1:] and _folder(together[-1][0]) == _folder(row[0]):
            together[-1][0] += f", `{row[0].strip('`').rpartition('.')[2]}`"
        else:
            together.append(list(row))
    return together


def _folder(names: str) -> str:
    return names.partition("`, `")[0].strip("`").rpartition(".")[0]


def _is_form(kind: type) -> bool:
    return issubclass(kind, BaseModel) and kind is not Quantity


def _kinds(annotation: Any) -> Iterator[Any]:
    """Give the types that an annotation is made of, without None and without their bounds."""
    origin = get_origin(annotation)
    if origin is Annotated:
        yield from _kinds(get_args(annotation)[0])
    elif origin in (Union, UnionType):
        for one in get_args(annotation):
            if one is not NoneType:
                yield from _kinds(one)
    elif origin in (list, dict):
        yield from _kinds(get_args(annotation)[-1])
    else:
        yield annotation


def _bounds(annotation: Any, metadata: Iterable[Any] = ()) -> Iterator[Any]:
    """Give what bounds a number, wherever in the annotation it stands."""
    yield from metadata
    if get_origin(annotation) is Annotated:
        inner, *more = get_args(annotation)
        yield from _bounds(inner, more)
    elif get_origin(annotation) in (Union, UnionType, list):
        for one in get_args(annotation):
            yield from _bounds(one)


def _allowed(info: FieldInfo) -> str:
    annotation = info.annotation
    union = get_origin(annotation) in (Union, UnionType)
    members = [one for one in get_args(annotation) if one is not NoneType] if union else []
    told = (_of_member(one, info.metadata) for one in members or [annotation])
    return " or ".join(dict.fromkeys(told))


def _of_member(annotation: Any, metadata: Iterable[Any]) -> str:
    """Return what one of a union's members allows."""
    low = high = unit = words = ""
    for bound in _bounds(annotation, metadata):
        for one in getattr(bound, "metadata", [bound]):
            match one:
                case Ge(ge=value):
                    low = _number(value)
                case Gt(gt=value):
                    low = f"above {_number(value)}"
                case Le(le=value):
                    high = _number(value)
                case AfterValidator():
                    inside: Mapping[str, Any] = inspect.getclosurevars(one.func).nonlocals
                    words = inside.get("words", "")
                    if not words:
                        low, high = f"{inside['low']:g}", f"{inside['high']:g}"
                        unit = inside["unit"]
    kinds = list(_kinds(annotation))
    parts = [part for kind in kinds for part in _words(kind)]
    if high and float(high.replace(",", "")) >= NO_BOUND:
        high = ""
        parts = {"0": ["0 or more"], "above 0": ["above 0"]}.get(low, parts)
    if high:
        span = f"{low} to {high} {unit}".strip()
        parts = [f"{span}*" if Quantity in kinds else span]
    words = words or " or ".join(parts)
    return f"{MANY.get(get_origin(annotation), '')}{words}"


def _number(value: Any) -> str:
    return f"{value:,}" if isinstance(value, int) else f"{value:g}"


def _words(kind: Any) -> list[str]:
    if get_origin(kind) is Literal:
        return [f"`{value}`" for value in get_args(kind)]
    if kind is Quantity:
        return ["a number*"]
    return [{**NUMBERS, **WORDS}.get(kind, "a table")]


def _default(info: FieldInfo) -> str:
    if info.is_required():
        return "**needed**"
    value = info.get_default(call_default_factory=True)
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, float):
        return f"{value:g}"
    return f"`{value}`" if value not in (None, "", [], {}, ()) else ""
