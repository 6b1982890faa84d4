"""Finds the parts that effects act on, by kind and unit and never by a machine's own names."""

from __future__ import annotations

from collections import Counter
from collections.abc import Container, Sequence

import numpy as np

from plant_model.machine import Input, Item, Machine
from plant_model.parameters import FloatArray

TOUCHES = 4
"""Least number of contacts of a part that may be the air of an enclosure: set on no data. Mistaking
another part for it costs a candidate that explains nothing."""


def input_in(machine: Machine, unit: str) -> Input | None:
    """Return the first input with a unit: ``rpm`` for spindle speed, ``Nm`` for its torque.

    Parameters
    ----------
    machine : Machine
    unit : str
        A suffix of `measurement.units.UNITS`.
    """
    return next((entry for entry in machine.inputs if entry.unit == unit), None)


def outside(machine: Machine) -> str:
    """Return the boundary temperature that most surfaces face, or else the first one.

    Parameters
    ----------
    machine : Machine
        Has at least one boundary temperature.
    """
    facing = Counter(item.refs["between"][1] for item in machine.of_kind("links", "convection"))
    return facing.most_common(1)[0][0] if facing else next(iter(machine.boundary_index))


def bearings(machine: Machine) -> list[Item]:
    """Return the bearings that friction heats.

    Parameters
    ----------
    machine : Machine
    """
    return machine.of_kind("sources", "bearing")


def foremost(machine: Machine, kind: str) -> int | None:
    """Return the node at the nose end of the ``shaft`` or the ``housing``, if there is one.

    Parameters
    ----------
    machine : Machine
    kind : {"shaft", "housing"}

    Returns
    -------
    int or None
        Its position among the nodes; None if the machine's structure has no such part.
    """
    parts = machine.of_kind("structure", kind)
    if not parts:
        return None
    front = max(parts, key=lambda item: item.parameters["end"].value)
    return machine.node_index[front.refs["nodes"][-1]]


def nose(machine: Machine) -> int | None:
    """Return the node nearest to the tool: the shaft's end, or else the first bearing's inner side.

    Parameters
    ----------
    machine : Machine

    Returns
    -------
    int or None
        Its position among the nodes; None if there is neither a shaft nor a bearing.
    """
    end = foremost(machine, "shaft")
    if end is None and bearings(machine):
        end = machine.node_index[bearings(machine)[0].refs["inner"][0]]
    return end


def spindle_nodes(machine: Machine) -> set[str]:
    """Return the nodes of shaft, housing, tool, bearings and motors.

    Parameters
    ----------
    machine : Machine
    """
    parts = machine.of_kind("structure", "shaft", "housing", "tool")
    parts = parts + machine.of_kind("sources", "bearing", "motor")
    roles = ("nodes", "inner", "outer", "rotor", "stator")
    return {name for item in parts for role in roles for name in item.refs.get(role, ())}


def bodies(machine: Machine) -> dict[str, str]:
    """Return the body of every node that is a cell of one: ``shaft`` or ``housing``.

    Parameters
    ----------
    machine : Machine
    """
    parts = machine.of_kind("structure", "shaft", "housing")
    return {name: part.kind for part in parts for name in part.refs["nodes"]}


def enclosed_air(machine: Machine) -> str | None:
    """Return the part that is the air of an enclosure, if the machine has one.

    Machine files do not name it: it is the part with the most contacts, if it has `TOUCHES` or
    more, does not belong to the spindle, is not drawn and does not move the tool or the work.

    Parameters
    ----------
    machine : Machine
    """
    members = [item for item in machine.items if item.family == "structure"]
    others = {name for item in members for name in item.refs.get("nodes", ())}
    others |= spindle_nodes(machine)
    others |= {node.name for node in machine.nodes if node.capacity.tied}  # to a drawn material
    touching = Counter(
        name
        for item in machine.of_kind("links", "contact")
        for name in item.refs["between"]
        if name not in others
    )
    name, count = touching.most_common(1)[0] if touching else ("", 0)
    return name if count >= TOUCHES else None


def base_node(machine: Machine) -> int:
    """Return the column: the heaviest part that moves the nose and gives heat to the hall.

    If no part does both, the heaviest that gives heat to the hall, or else the heaviest.

    Parameters
    ----------
    machine : Machine

    Returns
    -------
    int
        Its position among the nodes.
    """
    open_to_air = {item.refs["between"][0] for item in machine.of_kind("links", "convection")}
    return _heaviest(machine, open_to_air & _movers(machine), open_to_air, machine.node_index)


def carrier_node(machine: Machine) -> int:
    """Return the part that carries the spindle: the heaviest mover that passes heat to the column.

    If no such part moves the nose, the heaviest that passes heat to the column.

    Parameters
    ----------
    machine : Machine

    Returns
    -------
    int
        Its position among the nodes; that of `base_node` if nothing passes heat to the column.
    """
    base = machine.nodes[base_node(machine)].name
    pairs = [item.refs["between"] for item in machine.of_kind("links", "conduction", "contact")]
    beside = {name for pair in pairs if base in pair for name in pair} - {base}
    return _heaviest(machine, beside & _movers(machine), beside, {base})


def _movers(machine: Machine) -> set[str]:
    """Return the parts outside the spindle that move the nose by growing or bending.

    A bed or a foot that only stores heat may be heavier than the column.
    """
    members = machine.of_kind("structure", "member", "bend")
    nodes = {name for item in members for names in item.refs.values() for name in names}
    return nodes - spindle_nodes(machine)


def _heaviest(machine: Machine, *among: Container[str]) -> int:
    """Return the heaviest node of the first of *among* that holds one."""
    for names in among:
        chosen = [node for node in machine.nodes if node.name in names]
        if chosen:
            return machine.node_index[max(chosen, key=lambda node: node.capacity.value).name]
    raise ValueError("no node is among these")


def around_bearing(machine: Machine, bearing: Item) -> tuple[tuple[int, ...], tuple[int, ...]]:
    """Return the parts of the shaft and of the housing that a bearing sits between.

    These are the parts that its inner and outer sides touch, apart from each other; a side that
    touches nothing else stands for itself.

    Parameters
    ----------
    machine : Machine
    bearing : Item
        A source of kind ``bearing``.

    Returns
    -------
    two tuples of int
        Positions of nodes.
    """
    sides = []
    for side, other in (("inner", "outer"), ("outer", "inner")):
        (own,), (opposite,) = bearing.refs[side], bearing.refs[other]
        pairs = [item.refs["between"] for item in machine.of_kind("links", "conduction", "contact")]
        beside = {name for pair in pairs if own in pair for name in pair} - {own, opposite}
        names = [node.name for node in machine.nodes if node.name in beside] or [own]
        sides.append(tuple(machine.node_index[name] for name in names))
    return sides[0], sides[1]


def measured_parts(machine: Machine) -> list[str]:
    """Return the nodes that have a thermometer, in the order of the thermometers.

    Parameters
    ----------
    machine : Machine
    """
    read = dict.fromkeys(sensor.of for sensor in machine.sensors)
    return [name for name in read if name in machine.node_index]


def structure_parts(machine: Machine) -> list[str]:
    """Return the column and the part that it carries: the work or a probe stands on them.

    Parameters
    ----------
    machine : Machine

    Returns
    -------
    list of str
        Names of nodes; only one if nothing is carried.
    """
    carriers = dict.fromkeys((base_node(machine), carrier_node(machine)))
    return [machine.nodes[node].name for node in carriers]


def incidence(nodes: Sequence[int], count: int) -> FloatArray:
    """Return the matrix, shape (len(nodes), count), with a 1 for each row at its node.

    Parameters
    ----------
    nodes : sequence of int
        Position of each row's node.
    count : int
        Number of nodes of the machine.
    """
    matrix = np.zeros((len(nodes), count))
    matrix[np.arange(len(nodes)), list(nodes)] = 1.0
    return matrix
