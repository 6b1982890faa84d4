"""A cooler that switches on the spindle's temperature, as the studies' does.

The coolant of all jackets goes round through one tank, and the effect ``chiller`` cools that: it
runs from where one thermometer's part is too warm until it is cold enough. So the coolant follows
the spindle, and the temperatures go up and down with it.
"""

from __future__ import annotations

from dataclasses import replace

from plant_model.effects import catalogue
from plant_model.machine import Item, Machine, Node
from plant_model.parameters import Parameter

TANK = "tank"
INLET = "coolant_inlet"


def with_cooler(
    machine: Machine,
    *,
    watches: str,
    on_above: float,
    off_below: float,
    power: float,
    capacity: float,
    loss: float,
) -> Machine:
    """Return the machine with its coolant going round through a tank, instead of from an inlet.

    Parameters
    ----------
    machine : Machine
        Its boundary ``coolant_inlet`` feeds the jackets; a thermometer of it then reads the tank.
    watches : str
        The thermometer of the part that switches the chiller.
    on_above, off_below : float
        Where it switches [degC].
    power : float
        What the chiller takes while it runs [W].
    capacity : float
        Heat capacity of the coolant going round [J/K].
    loss : float
        From tank and hoses to the air [W/K].
    """
    watched = next(sensor.of for sensor in machine.sensors if sensor.name == watches)
    items = []
    for item in machine.items:
        if item.kind == "coolant_flow":
            jacket, _ = item.refs["between"]
            back = replace(item, name=f"{TANK}-{jacket}", refs={"between": (TANK, jacket)})
            items += [replace(item, refs={"between": (jacket, TANK)}), back]
        else:
            items.append(item)
    film = {"area": _fixed(1.0, "m2"), "coefficient": _fixed(loss, "W/(m2 K)")}
    switched = {
        "power": _fixed(power, "W"),
        "on_above": _fixed(on_above, "degC"),
        "dead_band": _fixed(on_above - off_below, "K"),
    }
    items += [
        Item("links", f"{TANK}-ambient", "convection", {"between": (TANK, "ambient")}, film),
        Item("sources", "chiller", "chiller", {"cools": (TANK,), "watches": (watched,)}, switched),
    ]
    return replace(
        machine,
        inputs=tuple(entry for entry in machine.inputs if entry.name != INLET),
        nodes=(*machine.nodes, Node(TANK, _fixed(capacity, "J/K"), "ambient")),
        items=tuple(items),
        sensors=tuple(
            replace(sensor, of=TANK) if sensor.of == INLET else sensor for sensor in machine.sensors
        ),
        effects=machine.effects | {"chiller": dict(catalogue()["chiller"].parameters)},
    )


def _fixed(value: float, unit: str) -> Parameter:
    return Parameter(value, unit, value, value, "study_size.toml")
