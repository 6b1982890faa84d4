"""Idle inputs and axes of a machine: inputs that nothing uses, axes that nothing moves."""

from __future__ import annotations

import re

import numpy as np
import pandas as pd

from plant_model.machine import Input, Machine
from plant_model.simulate import Simulation, simulate

FOUND_BY_UNIT = ("rpm", "Nm")
"""Units by which effects find spindle speed and torque; only effects may use a torque."""

TAKERS = {
    "mm_min": "a carrier says feed = { input = NAME }",
    "degC": "a jacket says inlet = NAME, a part air = NAME",
}
"""How a page uses an input of each unit."""


def unused_inputs(machine: Machine) -> list[str]:
    """Return a sentence for each input that nothing in the machine uses.

    Parameters
    ----------
    machine : Machine
    """
    used = {name for item in machine.items for names in item.refs.values() for name in names}
    used |= {sensor.of for sensor in machine.sensors}
    used |= {word for key in machine.effects for word in re.split(r"[:+]", key)[1:]}
    for unit in FOUND_BY_UNIT:
        used |= {entry.name for entry in machine.inputs if entry.unit == unit}
    return [_unused(entry) for entry in machine.inputs if entry.name not in used]


def _unused(entry: Input) -> str:
    taker = TAKERS.get(entry.unit, "").replace("NAME", f'"{entry.name}"')
    hint = f": {taker}, where it counts" if taker else ""
    return f"Nothing uses the input {entry.name} (column {entry.column}){hint}."


def still_axes(machine: Machine, shown: Simulation, inputs: pd.DataFrame) -> list[str]:
    """Return a sentence for each axis of the rig that nothing in the machine moves.

    Parameters
    ----------
    machine : Machine
    shown : Simulation
        Of the warm-up.
    inputs : DataFrame
        The inputs of the warm-up.
    """
    still = _still(machine, shown)
    if still:
        # Hall, coolant or torque may move an axis that does not move in a steady hall.
        still &= _still(machine, simulate(machine, _stirred(machine, inputs), step_s=60.0))
    lines = []
    for axis in sorted(still):
        sensors = ", ".join(name for name, seen in machine.probes.items() if seen == axis)
        lines.append(
            f"Nothing moves {axis}: {sensors} would stay at zero. No grows in"
            f" {axis.lower()}, no bends, no side that is warmer than the other."
        )
    return lines


def _still(machine: Machine, shown: Simulation) -> set[str]:
    moves = ~np.isclose(shown.drift(0.0)[0], 0.0).all(axis=0)  # rounding remains if terms cancel
    return {axis for axis in machine.probes.values() if not moves["XYZ".index(axis)]}


def _stirred(machine: Machine, inputs: pd.DataFrame) -> pd.DataFrame:
    """Return the warm-up with all inputs moved by a quarter from the second row on."""
    moved = inputs.copy()
    for entry in machine.inputs:
        moved.loc[1:, entry.name] += 0.25 * (entry.high - moved[entry.name])
    return moved
