"""Cooling jackets with a constant flow."""

from __future__ import annotations

from typing import ClassVar

from plant_model.anatomy import incidence
from plant_model.effects.base import Effect, ItemSpec, NumberSpec, amplitude, exchange
from plant_model.parameters import FloatArray, Parameter


def carried_from_inlets(effect: Effect, factor: FloatArray) -> FloatArray:
    """Return what the flows that a boundary feeds bring into each node [W/K].

    Parameters
    ----------
    effect : Effect
        Any effect of the machine.
    factor : array, shape (sets or 1, 1)
        On every flow, besides the scale of ``coolant_jacket``.

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


class CoolantJacket(Effect):
    """A well-mixed jacket: C dT/dt = V rho c (T_in - T) + sum UA (T_wall - T).

    ``coolant_flow`` joins a jacket to what feeds it (the inlet temperature, or another jacket in
    series, which the flow leaves behind unchanged); ``coolant_wall`` joins a wall to the jacket.
    The outlet has the jacket's temperature.
    """

    name: ClassVar[str] = "coolant_jacket"
    title: ClassVar[str] = "Coolant jackets at constant flow"
    explanation: ClassVar[str] = (
        "Coolant carries heat away in proportion to flow and temperature rise."
    )
    parameters: ClassVar[dict[str, Parameter]] = {
        "scale": amplitude(1.0, 0.0, 2.0, "factor on flow and wall conductance, 1 as given")
    }
    amplitude: ClassVar[str] = "scale"
    handles: ClassVar[dict[tuple[str, str], ItemSpec]] = {
        ("links", "coolant_flow"): ItemSpec(
            refs={"between": "node,node|boundary"},
            numbers={
                "flow": NumberSpec("l/min", 0.0, 1e3),
                "heat_capacity": NumberSpec("J/(l K)", 100.0, 5000.0),
            },
        ),
        ("links", "coolant_wall"): ItemSpec(
            refs={"between": "node,node"},
            numbers={"conductance": NumberSpec("W/K", 0.0, 1e5)},
        ),
    }

    def prepare(self) -> None:
        """Put the conductances into the constant exchanges."""
        scale = self.own("scale")
        exchanges = []
        for item in self.items:
            if item.kind == "coolant_flow":
                g = scale * self.of(item, "flow") / 60.0 * self.of(item, "heat_capacity")
                exchanges.append(exchange(self, item, g, one_way=True))
            else:
                g = scale * self.of(item, "conductance")
                exchanges.append(exchange(self, item, g))
        self.constant_exchanges = exchanges
