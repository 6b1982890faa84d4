"""Generates the C data of a compensator file from the objects that the Python FMU uses.

Nothing about a model or a variable is written twice: the file's tables, its sensors and limits, the
variables, the status texts and the runtime's constants come from the Python objects. Anything
without a counterpart in the C program does not compile, or is refused here.
"""

from __future__ import annotations

import ast
import inspect
import pkgutil
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import fields
from importlib import import_module
from itertools import chain
from math import sqrt
from operator import mul
from pathlib import Path
from typing import Any

from fmu_compensator import runtime
from fmu_compensator.plugins import plugged_error_models
from fmu_compensator.runtime.compensator import STATUS_TEXTS
from fmu_compensator.runtime.error_models import error_models, shipped_error_models
from fmu_compensator.runtime.fmi_slave import MEASURED, REALS
from fmu_compensator.runtime.gaussian import MOST_PROBES, OF_FIXED
from fmu_compensator.runtime.modelfile import Model
from fmu_packaging.native.compilers import NativeError
from fmu_packaging.variables import Variable

C_FOLDER = Path(__file__).resolve().parent / "c"
ERROR_MODELS = "error_models"
KIND = re.compile(r"^const struct error_model_kind (\w+)_kind\b", re.MULTILINE)
MEMBERS = [f"{name}[{place}]" for name in ("offset", "pose", "half_width") for place in range(3)]
"""Members of the struct of outputs, in the order of `REALS`."""
TEXT_OUTPUT = "status_text"
HEAD = "/* Made by spindle-drift from {what}; not to be edited. */\n"


def program() -> dict[str, str]:
    """Return the sources shared by all compensators, by path in the source folder."""
    paths = sorted([*C_FOLDER.rglob("*.c"), *C_FOLDER.rglob("*.h")])
    sources = {path.relative_to(C_FOLDER).as_posix(): path.read_text("utf-8") for path in paths}
    return sources | _plugged()


def kinds() -> list[str]:
    """Return the error models with a C twin, including kinds that share one."""
    return sorted(KIND.findall("\n".join(program().values())))


def _plugged() -> dict[str, str]:
    """Return the C twins of plug-ins: a file of the same name next to it, or the class's text."""
    sources = {}
    for kind, plugin in plugged_error_models(frozenset(shipped_error_models())).items():
        file = Path(inspect.getfile(plugin.thing)).with_suffix(".c")
        if plugin.thing.c_twin:
            sources[f"{ERROR_MODELS}/{kind}.c"] = plugin.thing.c_twin
        elif file.is_file():
            sources[f"{ERROR_MODELS}/{file.name}"] = file.read_text("utf-8")
    return sources


def data_sources(model: Model, variables: Sequence[Variable], name: str, guid: str) -> str:
    """Return ``model_data.c`` of a compensator file.

    Parameters
    ----------
    model : Model
    variables : sequence of Variable
        In the order of their value references.
    name, guid : str
        Of the FMU.

    Raises
    ------
    NativeError
        If the file or a variable has no counterpart in the C program.
    """
    for kind in _kinds_used(model.table["error_model"]):
        if kind not in kinds():
            raise NativeError(f"{model.source}: error_model.kind: {kind!r} has no C twin")
    tree = _Tree()
    error_model = tree.field(model.table["error_model"], None)
    geometry, spare = _geometry(model, tree), _spare(model.table.get("spare"), tree)
    gaussian = _gaussian(model.table["gaussian"], tree)
    names = kinds()
    addresses = [f"&{kind}_kind" for kind in names]
    texts = [f"{{{status}, {_text(text)}}}" for status, text in STATUS_TEXTS.items()]
    chosen = ", ".join(map(str, model.chosen))
    mean = model.new_error_model()  # if it is linear, so are the offsets, except for the geometry
    derived = "&compensator_derivatives" if mean.linear else "NULL"
    lines = [
        HEAD.format(what=f"the compensator file {model.name}"),
        '#include "model_data.h"\n\n#include <math.h>\n\n#include "compensator.h"\n',
        f"const char *const model_guid = {_text(guid)};",
        f"const char *const model_name = {_text(name)};\n",
        *_table("struct sensor", "model_sensors", map(_struct, model.sensors)),
        f"const size_t model_sensor_count = {len(model.sensors)};",
        f"const size_t model_chosen[] = {{{chosen}}};",
        f"const size_t model_chosen_count = {len(model.chosen)};",
        f"const size_t model_target_count = {len(model.targets)};",
        f"const bool model_takes_rises = {_literal(model.input_form == 'rise')};",
        f"const struct limits model_limits = {_struct(model.limits)};",
        "",
        *tree.lines,
        f"const struct field model_error_model = {error_model};",
        f"const struct geometry_data model_geometry = {geometry};",
        f"const struct gaussian_data model_gaussian = {gaussian};",
        f"const struct spare_data model_spare = {spare};",
        f"const bool model_uses_measured = {_literal(mean.uses_measured)};",
        "#ifdef NO_HEAP /* a controller asks for none */",
        "const struct derivatives *const model_derivatives = NULL;",
        "#else",
        f"const struct derivatives *const model_derivatives = {derived};",
        "#endif",
        "",
        *(f"extern const struct error_model_kind {kind}_kind;" for kind in names),
        *_table("struct error_model_kind *const", "model_kinds", [*addresses, "NULL"]),
        *_table("struct status_text", "model_status_texts", [*texts, "{0, NULL}"]),
        *_table("struct variable", "model_variables", map(_variable, variables)),
        f"const size_t model_variable_count = {len(variables)};",
        f"const struct ports model_ports = {_ports(model, variables)};",
    ]
    return "\n".join(lines) + "\n"


def constants() -> str:
    """Return ``constants.h``: the runtime's numeric constants that the C program uses.

    ``SPAN_S`` of the module ``checks`` is ``CHECKS_SPAN_S`` here.
    """
    words = set(re.findall(r"\b[A-Z][A-Z0-9_]+\b", "\n".join(program().values())))
    lines = [
        f"#define {name} {_literal(value)}" for name, value in _runtime_numbers() if name in words
    ]
    what = "the constants of the Python runtime"
    return (
        f"{HEAD.format(what=what)}#ifndef CONSTANTS_H\n#define CONSTANTS_H\n\n"
        + "\n".join(lines)
        + "\n\n#endif\n"
    )


def _runtime_numbers() -> Iterator[tuple[str, int | float]]:
    """Yield the numeric constants of each runtime module and error model."""
    own = [info.name for info in pkgutil.walk_packages(runtime.__path__, f"{runtime.__name__}.")]
    plugged = {error_models()[kind].__module__ for kind in error_models()}
    for name_of_module in sorted({*own, *plugged}):
        module = import_module(name_of_module)
        for statement in ast.parse(inspect.getsource(module)).body:
            if isinstance(statement, ast.Assign):
                for node in ast.walk(ast.Tuple(statement.targets)):
                    name = node.id if isinstance(node, ast.Name) else ""
                    value = getattr(module, name) if name.isupper() else None
                    if isinstance(value, int | float) and not isinstance(value, bool):
                        yield f"{name_of_module.rpartition('.')[2].upper()}_{name}", value


def _kinds_used(table: Mapping[str, Any]) -> Iterator[str]:
    yield str(table["kind"])
    for inner in table.get("models", []):
        yield from _kinds_used(inner)


class _Tree:
    """A JSON value as constants of type ``struct field``; `lines` define their contents."""

    def __init__(self) -> None:
        self.lines: list[str] = []
        self._count = 0

    def field(self, value: object, name: str | None) -> str:
        """Return the initialiser of one value."""
        label = "NULL" if name is None else _text(name)
        if value is None:
            return f"{{{label}, FIELD_NULL, 0, NULL, NULL, NULL}}"
        if isinstance(value, str):
            return f"{{{label}, FIELD_TEXT, 1, NULL, {_text(value)}, NULL}}"
        if isinstance(value, int | float):
            return self._numbers(label, "FIELD_NUMBER", 1, [value])
        if isinstance(value, dict):
            items = [self.field(item, key) for key, item in value.items()]
            return self._items(label, "FIELD_TABLE", items)
        assert isinstance(value, list)
        if value and all(isinstance(item, int | float) for item in value):
            return self._numbers(label, "FIELD_NUMBERS", len(value), value)
        if value and all(_is_row(item) for item in value):
            flat = [number for row in value for number in row]
            return self._numbers(label, "FIELD_MATRIX", len(value), flat)
        return self._items(label, "FIELD_LIST", [self.field(item, None) for item in value])

    def _numbers(self, label: str, form: str, count: int, numbers: Sequence[float]) -> str:
        place = self._row(numbers)
        return f"{{{label}, {form}, {count}, {place}, NULL, NULL}}"

    def rows(self, rows: Mapping[str, Iterable[float]]) -> dict[str, str]:
        """Return pointers to rows of numbers; NULL if there are none."""
        return {key: self._row(numbers) for key, numbers in rows.items()}

    def _row(self, numbers: Iterable[float]) -> str:
        return self._new("static const double", [_literal(float(number)) for number in numbers])

    def _items(self, label: str, form: str, items: list[str]) -> str:
        place = self._new("static const struct field", items)
        return f"{{{label}, {form}, {len(items)}, NULL, NULL, {place}}}"

    def _new(self, kind: str, rows: list[str]) -> str:
        if not rows:
            return "NULL"
        self._count += 1
        name = f"part_{self._count}"
        self.lines += [f"{kind} {name}[] = {{", *(f"    {row}," for row in rows), "};"]
        return name


def _geometry(model: Model, tree: _Tree) -> str:
    geometry, table = model.geometry, model.table["geometry"]
    values: dict[str, object] = {"needs_tool_length": geometry.needs_tool_length}
    if geometry.needs_tool_length:
        turning = table["form"] == "pure_rotation"
        values["near_mm"] = 0.0 if turning else float(table["near_to_gauge_mm"])
        values["radial"] = 0.0 if turning else 1.0
    return _parts(values, tree.rows({"weights": chain(*geometry.weights(0.0))}))


def _gaussian(table: Mapping[str, Any], tree: _Tree) -> str:
    constant = table["constant"]
    weights = zip(table["weights"], constant, strict=True)
    seen = [[*row, 0.0] for row in table["seen"]]
    tables = [seen[at : at + MOST_PROBES] for at in range(0, len(seen), MOST_PROBES)]
    values: dict[str, object] = {
        key: float(table[key]) for key in ("settled_h", "walk_per_h", "deviations")
    }
    width = len(table["weights"][0])
    inputs = width // len(table["scale"])
    values |= {"lags": len(table["lags_s"]), "width": width, "inputs": inputs}
    values["speed_rpm"] = float(table.get("speed_rpm", 0.0))
    rows = {
        "usual": table["usual"] if table["reference"] == OF_FIXED else [],
        "lags_s": table["lags_s"],
        "prior": [value for value in table["scale"] for _ in range(inputs)],
        "noise": chain(*zip(*table["noise"], strict=True)),
        "spread": [sqrt(sum(map(mul, row, row))) for row in table["noise"]],
        "mean_share": table.get("mean_share", [1.0] * len(constant)),
        "weights": _in_lanes([[*row, constant] for row, constant in weights]),
        "seen": [number for some in tables for number in _in_lanes(some)],
    }
    return _parts(values | {"tables": len(tables)}, tree.rows(rows))


def _in_lanes(rows: Sequence[Sequence[float]]) -> list[float]:
    """Return the numbers of up to `MOST_PROBES` rows, column by column."""
    more = [[0.0] * len(rows[0])] * (MOST_PROBES - len(rows))
    return [number for column in zip(*rows, *more, strict=True) for number in column]


def _spare(table: Mapping[str, Any] | None, tree: _Tree) -> str:
    if table is None:
        return _parts({"memory_s": 0.0})
    rows = {
        "precision": chain(*table["precision"]),
        "growth": table["growth"],
        "sensitivity": chain(*zip(*table["sensitivity"], strict=True)),
        "usual_start": table["usual_start"] or [],
    }
    return _parts({"memory_s": float(table["memory_s"])}, tree.rows(rows))


def _is_row(value: object) -> bool:
    return isinstance(value, list) and all(isinstance(item, int | float) for item in value)


def _table(kind: str, name: str, rows: Iterable[str]) -> list[str]:
    return [f"const {kind} {name}[] = {{", *(f"    {row}," for row in rows), "};"]


def _struct(thing: Any) -> str:
    """Return a dataclass as an initialiser; a field missing in the C type does not compile."""
    return _parts({field.name: getattr(thing, field.name) for field in fields(thing)})


def _parts(values: Mapping[str, object], places: Mapping[str, str] | None = None) -> str:
    """Return values, and pointers to others, as an initialiser."""
    parts = {name: _literal(value) for name, value in values.items()} | dict(places or {})
    return f"{{{', '.join(f'.{name} = {value}' for name, value in parts.items())}}}"


def _literal(value: object) -> str:
    """Return a value in C, floats with all digits."""
    if isinstance(value, str):
        return _text(value)
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, tuple):
        return f"{{{', '.join(map(_literal, value))}}}"
    if value is None or value != value:
        return "NAN"
    text = repr(value)
    return f"({text})" if text.startswith("-") else text


def _text(text: str) -> str:
    """Return a string in C, with other characters than plain ASCII byte by byte."""
    plain = (
        chr(byte) if 32 <= byte < 127 and chr(byte) not in '"\\?' else f"\\{byte:03o}"
        for byte in text.encode()
    )
    return f'"{"".join(plain)}"'


def _variable(variable: Variable) -> str:
    offset, start = "0", 0.0
    if variable.clock:
        causality = "SENT" if variable.is_output else "RECEIVED"
        start = float(variable.start or 0.0)
        return f"{{{_text(variable.name)}, REAL, {causality}, {_literal(start)}, 0}}"
    if variable.is_output and variable.kind != "string":
        # An output that the C program does not compute has no member and so does not compile.
        member = dict(zip(REALS, MEMBERS, strict=True)).get(variable.name, variable.name)
        offset = f"offsetof(struct output, {member})"
    if variable.is_output and variable.kind == "string" and variable.name != TEXT_OUTPUT:
        raise NativeError(f"{variable.name}: the C program has no such text")
    if variable.causality == "input" and not isinstance(variable.start, str | None):
        start = float(variable.start)
    kind, causality = variable.kind.upper(), variable.causality.upper()
    return f"{{{_text(variable.name)}, {kind}, {causality}, {_literal(start)}, {offset}}}"


def _ports(model: Model, variables: Sequence[Variable]) -> str:
    """Return the value references that the C program needs.

    Raises
    ------
    NativeError
        For an input or a parameter unknown to it.
    """
    refs = {variable.name: ref for ref, variable in enumerate(variables)}
    measured = [f"{MEASURED}_{target}" for target in model.targets]
    sensors = [sensor.name for sensor in model.sensors]
    expected = [*sensors, "speed", "tool_length", *measured, MEASURED]
    # A point in the name marks a variable of a terminal.
    inputs = [v.name for v in variables if not v.is_output and "." not in v.name]
    for name, wanted in zip(
        [*inputs, "nothing"], [*expected, "model_file", "nothing"], strict=False
    ):
        if name != wanted:
            raise NativeError(f"{name}: the C program has no such input or parameter here")
    names = {
        "speed": "speed",
        "tool_length": "tool_length",
        "measured_targets": measured[0],
        "measured": MEASURED,
    }
    parts = [f".{port} = {refs[name]}" for port, name in names.items()]
    return f"{{{', '.join(parts)}}}"
