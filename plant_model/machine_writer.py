"""Writing a machine back into its file: changed values and added effects; the rest is kept."""

from __future__ import annotations

import tomllib
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any, TypeVar

import tomlkit

from measurement.errors import BadInput
from measurement.files import write_atomically
from plant_model.drawing.expand import is_page
from plant_model.effect_names import name_of
from plant_model.effects import catalogue
from plant_model.machine import FAMILIES, Item, Machine
from plant_model.machine_file import machine_from_table, machine_path, machine_table
from plant_model.parameters import Parameter

T = TypeVar("T")


def write_machine(
    machine: Machine,
    original: str | Path,
    path: str | Path,
    *,
    finish: Callable[[str], str] = str,
) -> Path:
    """Write a machine that was read from a file and then changed or extended.

    Parameters
    ----------
    machine : Machine
        Same nodes, items and sensors as in the original and in the same order; values, starts and
        the nodes that items join may differ. More nodes, and more items of each family, may follow.
    original : str or path
        The file (or shipped name) that it came from; its comments and order are kept.
    path : path
        Where to write; the file is replaced as a whole or not at all.
    finish : callable, optional
        Last change to the text, for example a comment at the top.

    Returns
    -------
    Path
        The path given.

    Raises
    ------
    BadInput
        If *original* is not the file of this machine, or *path* cannot be written.
    """
    return write_atomically(path, finish(machine_text(machine, original)))


def machine_text(machine: Machine, original: str | Path) -> str:
    """Return the text that `write_machine` writes.

    Parameters
    ----------
    machine, original
        As for `write_machine`.

    Raises
    ------
    BadInput
        If *original* is not the file of this machine.
    """
    source = machine_path(original)
    head, document = _document(source)
    for name, number in machine.numbers.items():
        _put(document["numbers"], name, number)
    for node, entry in _beside(document["nodes"], machine.nodes):
        _put(entry, "name", node.name)
        _put(entry, "capacity", node.capacity)
        _put(entry, "start", node.start, "ambient")
        _put(entry, "start_share", node.start_share, 1.0)
    for sensor, entry in _beside(document.get("sensors", []), machine.sensors):
        _put(entry, "of", sensor.of)
    for family in FAMILIES:
        items = [item for item in machine.items if item.family == family]
        for item, entry in _beside(document.setdefault(family, tomlkit.aot()), items):
            _put_item(entry, item)
    _put_effects(document["effects"], machine)
    text: str = head + document.as_string()
    # The text must read back as the same machine.
    if machine_from_table(tomllib.loads(text), source) != machine:
        raise BadInput(source, "", "is not the file that this machine came from")
    return text


def _document(source: Path) -> tuple[str, Any]:
    """Return a first line and the file to change; a page is replaced by its expansion in lumps."""
    text = source.read_text(encoding="utf-8")
    if is_page(tomllib.loads(text)):
        return f"# Expanded from the page {source.name}.\n\n", tomlkit.item(machine_table(source))
    return "", tomlkit.parse(text)


def _beside(entries: Any, things: Sequence[T]) -> Iterator[tuple[T, Any]]:
    """Yield each thing with its table in the file, or with a new one if there is none."""
    for place, thing in enumerate(things):
        if place == len(entries):
            entries.append(tomlkit.table())
        yield thing, entries[place]


def _put_item(entry: Any, item: Item) -> None:
    """Write an item; if its references differ from the file's, it keeps its name."""
    is_new = not entry
    if is_new:
        entry["kind"], entry["name"] = item.kind, item.name
    for role, names in item.refs.items():
        given = entry.get(role)
        if tuple(given if isinstance(given, list) else [given]) != names:
            entry.setdefault("name", item.name)
            entry[role] = list(names) if len(names) > 1 else names[0]
    for name, parameter in item.parameters.items():
        if is_new or name in entry:
            _put(entry, name, parameter)


def _put_effects(effects: Any, machine: Machine) -> None:
    for key, parameters in machine.effects.items():
        if key not in effects:
            effects[key] = tomlkit.table()
        nominal = catalogue()[name_of(key)].parameters
        for name, parameter in parameters.items():
            if name in effects[key] or parameter != nominal[name]:
                _put(effects[key], name, parameter)


def _put(entry: Any, key: str, value: Any, usual: object = None) -> None:
    """Write a value if the file has another; a missing entry in the file means *usual*."""
    if not isinstance(value, Parameter):
        if entry.get(key, usual) != value:
            entry[key] = value
    elif key not in entry:
        entry[key] = _inline(value)
    elif not value.tied:
        for part in ("value", "low", "high", "source"):
            _put(entry[key], part, getattr(value, part))
        _put(entry[key], "calibrate", value.calibrate, usual=False)


def _inline(parameter: Parameter) -> Any:
    table = tomlkit.inline_table()
    table.update(parameter.to_dict())
    return table
