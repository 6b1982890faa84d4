"""Heat exchanged by parts with each other and with their surroundings."""

from __future__ import annotations

from dataclasses import dataclass

from plant_model.machine import Item, Machine
from plant_model.parameters import FloatArray


@dataclass(frozen=True)
class Exchange:
    """Heat that *node* receives from a node or a boundary temperature: g (T_other - T_node) [W].

    Attributes
    ----------
    node, other : int
        Positions; *other* counts boundaries if ``boundary`` is set.
    conductance : array, shape (sets or 1, times or 1)
        g [W/K].
    boundary : bool
        Whether *other* is a boundary temperature.
    one_way : bool
        Whether a flow carries the heat from *other*, which gets nothing back (series coolant).
    """

    node: int
    other: int
    conductance: FloatArray
    boundary: bool = False
    one_way: bool = False


def exchange(
    machine: Machine, item: Item, conductance: FloatArray, *, one_way: bool = False
) -> Exchange:
    """Return the exchange of a link.

    Parameters
    ----------
    machine : Machine
    item : Item
        With the role ``between``.
    conductance : array, shape (sets or 1, times or 1)
        [W/K].
    one_way : bool
        As in `Exchange`.
    """
    first, second = item.refs["between"]
    if second in machine.boundary_index:
        index = machine.boundary_index[second]
        return Exchange(machine.node_index[first], index, conductance, boundary=True)
    node, other = machine.node_index[first], machine.node_index[second]
    return Exchange(node, other, conductance, one_way=one_way)
