"""Cooling jackets with a constant flow."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from plant_model.anatomy import incidence
from plant_model.effects.base import Effect, Inputs, amplitude
from plant_model.exchange import Exchange, exchange
from plant_model.item_forms import ItemSpec, NumberSpec
from plant_model.machine import Machine
from plant_model.parameters import FloatArray, Values


def carried_from_inlets(effect: Effect, factor: FloatArray) -> FloatArray:
    """Return the heat capacity rate of the flows from boundaries into each node [W/K].

    Parameters
    ----------
    effect : Effect
        Any effect of the machine.
    factor : array, shape (sets or 1, 1)
        Factor on every flow, in addition to the scale of ``coolant_jacket``.

    Returns
    -------
    array, shape (sets or 1, 1, nodes)
        ``factor`` V rho c.
    """
    machine = effect.machine
    flows = [
        item
        for item in machine.of_kind("links", "coolant_flow")
        if item.refs["between"][1] in machine.boundary_index
    ]
    nodes = [machine.node_index[item.refs["between"][0]] for item in flows]
    scale = factor * effect.scale_of("coolant_jacket") / 60.0
    carried = [scale * effect.of(item, "flow") * effect.of(item, "heat_capacity") for item in flows]
    return effect.table(carried) @ incidence(nodes, len(machine.nodes))


@dataclass(frozen=True)
class Flow:
    """Coolant that flows into a jacket.

    Attributes
    ----------
    node : int
        Position of the jacket.
    feed : str
        Boundary or node that it comes from.
    conductance : array, shape (sets or 1, 1)
        V rho c [W/K].
    """

    node: int
    feed: str
    conductance: FloatArray

    def warmer(self, machine: Machine, inputs: Inputs, temperatures: FloatArray) -> FloatArray:
        """Return how much warmer it is than the jacket [K], (sets, times)."""
        index = machine.node_index
        feed = temperatures[..., index[self.feed]] if self.feed in index else inputs[self.feed]
        return np.asarray(feed - temperatures[..., self.node])


def flows_of(machine: Machine, values: Values) -> list[Flow]:
    """Return the flows into jackets; none if ``coolant_jacket`` is not in force.

    Parameters
    ----------
    machine : Machine
    values : Values
        The parameter sets.
    """
    if "coolant_jacket" not in machine.effects:
        return []
    scale = values["effects.coolant_jacket.scale"]
    flows = []
    for item in machine.of_kind("links", "coolant_flow"):
        flow, heat_capacity = (
            values[item.parameter_name(name)] for name in ("flow", "heat_capacity")
        )
        node, feed = item.refs["between"]
        flows.append(Flow(machine.node_index[node], feed, scale * (flow / 60.0 * heat_capacity)))
    return flows


class CoolantJacket(Effect):
    """A well-mixed jacket: C dT/dt = V rho c (T_in - T) + sum UA (T_wall - T).

    ``coolant_flow`` joins a jacket to its feed (the inlet temperature, or another jacket in series,
    which the flow does not change); ``coolant_wall`` joins a wall to the jacket. The outlet has the
    jacket's temperature.
    """

    title = "Coolant jackets at constant flow"
    explanation = "Coolant carries heat away in proportion to flow and temperature rise."
    parameters = {
        "scale": amplitude(1.0, 0.0, 2.0, "factor on flow and wall conductance, 1 as given")
    }
    handles = {
        ("links", "coolant_flow"): ItemSpec(
            refs={"between": "node,node|boundary"},
            numbers={
                "flow": NumberSpec("l/min", 0.0, 1e3),
                "heat_capacity": NumberSpec("J/(l K)", 100.0, 5000.0),
            },
            law="coolant flows into the first from the second: the inlet, or the jacket before it",
        ),
        ("links", "coolant_wall"): ItemSpec(
            refs={"between": "node,node"},
            numbers={"conductance": NumberSpec("W/K", 0.0, 1e5)},
            law="Q = conductance (Tb - Ta) between a wall and the jacket on it",
        ),
    }

    def prepare(self) -> None:
        """Put the conductances into the constant exchanges."""
        scale = self.own("scale")
        exchanges: list[Exchange] = []
        ways: dict[tuple[int, int], FloatArray] = {}
        for item in self.items:
            if item.kind == "coolant_wall":
                exchanges.append(exchange(self.machine, item, scale * self.of(item, "conductance")))
                continue
            g = scale * self.of(item, "flow") / 60.0 * self.of(item, "heat_capacity")
            flow = exchange(self.machine, item, g, one_way=True)
            if flow.boundary:
                exchanges.append(flow)
            else:
                way = flow.node, flow.other
                ways[way] = ways[way] + g if way in ways else g
        # Flows in both directions are an ordinary exchange, which the network steps exactly.
        for (node, other), g in ways.items():
            if (other, node) not in ways:
                exchanges.append(Exchange(node, other, g, one_way=True))
                continue
            both = np.minimum(g, ways[other, node])
            exchanges.append(Exchange(node, other, g - both, one_way=True))
            if node < other:
                exchanges.append(Exchange(node, other, both))
        self.constant_exchanges = exchanges
