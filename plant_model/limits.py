"""Physical limits of parameters, whatever range the file gives them."""

from __future__ import annotations

from plant_model.effect_names import name_of
from plant_model.effects import catalogue, item_kinds
from plant_model.effects.base import possible
from plant_model.item_forms import NumberSpec
from plant_model.machine import Machine
from plant_model.parameters import NUMBERS

CAPACITY = NumberSpec("J/K", 1e-3, 1e9)
"""Of a node."""


def physical_limits(machine: Machine) -> dict[str, tuple[float, float]]:
    """Return the lowest and highest possible value of each parameter, by full name, in its unit.

    A named number is limited by all parameters that follow it. The own numbers of an effect that
    gives items their law are limited by that law. Those of other effects are limited by their
    range, which states how large the effect can be and not how well it is known.
    """
    capacity = CAPACITY.low, CAPACITY.high
    limits = {f"nodes.{node.name}.capacity": capacity for node in machine.nodes}
    kinds = item_kinds()
    for item in machine.items:
        numbers = kinds[item.family, item.kind][1].numbers
        for name in item.parameters:
            limits[item.parameter_name(name)] = numbers[name].low, numbers[name].high
    for key, parameters in machine.effects.items():
        effect = catalogue()[name_of(key)]
        for name, parameter in parameters.items():
            within = possible(effect, name) if effect.handles else (parameter.low, parameter.high)
            limits[f"effects.{key}.{name}"] = within
    infinite = float("inf")
    free = {f"{NUMBERS}{name}": (-infinite, infinite) for name in machine.numbers}
    for name, parameter in machine.parameters.items():
        if parameter.tied and parameter.factor:
            low, high = sorted(end / parameter.factor for end in limits[name])
            so_far = free[parameter.tied]
            free[parameter.tied] = max(so_far[0], low), min(so_far[1], high)
    return limits | free
