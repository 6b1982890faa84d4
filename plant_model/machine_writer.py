"""Writing a machine back into its file: moved values and added effects, all else as it stands."""

from __future__ import annotations

import tomllib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import tomlkit

from measurement.errors import BadInput
from measurement.files import write_atomically
from plant_model.drawing.expand import is_page
from plant_model.effect_names import name_of
from plant_model.effects import catalogue
from plant_model.machine import FAMILIES, Item, Machine
from plant_model.machine_file import machine_from_table, machine_path, machine_table
from plant_model.parameters import Parameter


def write_machine(
    machine: Machine,
    original: str | Path,
    path: str | Path,
    *,
    finish: Callable[[str], str] = str,
) -> Path:
    """Write a machine that came from a file and was changed or added to.

    Parameters
    ----------
    machine : Machine
        Same nodes, items and sensors as in the original, in their order: with other values and
        starts, joined to other nodes. More nodes and, of each family, more items may stand behind.
    original : str or path
        The file (or shipped name) that it came from; its comments and order stay.
    path : path
        Where to write; replaced whole or not at all.
    finish : callable, optional
        Last change of the text, such as a comment on top.

    Returns
    -------
    Path
        The path given.

    Raises
    ------
    BadInput
        When *original* is not the file of this machine, or *path* cannot be written.
    """
    return write_atomically(path, finish(machine_text(machine, original)))


def machine_text(machine: Machine, original: str | Path) -> str:
    """Return what `write_machine` writes.

    Parameters
    ----------
    machine, original
        As `write_machine` takes them.

    Raises
    ------
    BadInput
        When *original* is not the file of this machine.
    """
    source = machine_path(original)
    head, document = _document(source)
    for name, number in machine.numbers.items():
        _move(document["numbers"], name, number)
    _write_nodes(document["nodes"], machine)
    _write_sensors(document, machine)
    _write_items(document, machine)
    _write_effects(document["effects"], machine)
    text: str = head + document.as_string()
    # What is written must read back as the same machine.
    if machine_from_table(tomllib.loads(text), source) != machine:
        raise BadInput(source, "", "is not the file that this machine came from")
    return text


def _document(source: Path) -> tuple[str, Any]:
    """Return a first line and the file to change; a page gives way to the machine file in lumps."""
    text = source.read_text(encoding="utf-8")
    if is_page(tomllib.loads(text)):
        return f"# Expanded from the page {source.name}.\n\n", tomlkit.item(machine_table(source))
    return "", tomlkit.parse(text)


def _write_nodes(entries: Any, machine: Machine) -> None:
    for place, node in enumerate(machine.nodes):
        if place == len(entries):
            table = tomlkit.table()
            table["name"], table["capacity"] = node.name, _inline(node.capacity)
            entries.append(table)
        entry = entries[place]
        _move(entry, "capacity", node.capacity)
        if entry.get("start", "ambient") != node.start:
            entry["start"] = node.start
        if entry.get("start_share", 1.0) != node.start_share:
            entry["start_share"] = node.start_share


def _write_sensors(document: Any, machine: Machine) -> None:
    for entry, sensor in zip(document.get("sensors", []), machine.sensors, strict=True):
        if entry["of"] != sensor.of:
            entry["of"] = sensor.of


def _write_items(document: Any, machine: Machine) -> None:
    counts = dict.fromkeys(FAMILIES, 0)
    for item in machine.items:
        entries = document.setdefault(item.family, tomlkit.aot())
        if counts[item.family] == len(entries):
            entries.append(_new_item(item))
        entry = entries[counts[item.family]]
        counts[item.family] += 1
        _write_refs(entry, item)
        for name, parameter in item.parameters.items():
            if name in entry:
                _move(entry, name, parameter)


def _write_refs(entry: Any, item: Item) -> None:
    """Write what an item touches, where that is not what the file says; it keeps its name."""
    for role, names in item.refs.items():
        given = entry[role]
        if tuple(given if isinstance(given, list) else [given]) != names:
            entry.setdefault("name", item.name)
            entry[role] = _names(names)


def _names(names: tuple[str, ...]) -> Any:
    return list(names) if len(names) > 1 else names[0]


def _new_item(item: Item) -> Any:
    """Return an item that the file does not have yet."""
    table = tomlkit.table()
    table["kind"], table["name"] = item.kind, item.name
    for role, names in item.refs.items():
        table[role] = _names(names)
    for name, parameter in item.parameters.items():
        table[name] = _inline(parameter)
    return table


def _write_effects(effects: Any, machine: Machine) -> None:
    for key, parameters in machine.effects.items():
        if key not in effects:
            effects[key] = tomlkit.table()
        nominal = catalogue()[name_of(key)].parameters
        for name, parameter in parameters.items():
            if name in effects[key]:
                _move(effects[key], name, parameter)
            elif parameter != nominal[name]:
                effects[key][name] = _inline(parameter)


def _move(entry: Any, name: str, parameter: Parameter) -> None:
    if parameter.tied:
        return
    for part in ("value", "low", "high", "source"):
        if entry[name][part] != getattr(parameter, part):
            entry[name][part] = getattr(parameter, part)
    if entry[name].get("calibrate", False) != parameter.calibrate:
        entry[name]["calibrate"] = parameter.calibrate


def _inline(parameter: Parameter) -> Any:
    table = tomlkit.inline_table()
    table.update(parameter.to_dict())
    return table
