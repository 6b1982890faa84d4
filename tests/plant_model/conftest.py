"""Machines and inputs that the plant's tests share."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest

from plant_model.effect_names import effect_key
from plant_model.effects import catalogue
from plant_model.machine import Item, Machine
from plant_model.machine_file import read_machine


def inputs_over(
    hours: float, *, speed: float = 9000.0, every_s: float = 10.0, steps: bool = True
) -> pd.DataFrame:
    """Return inputs with speed steps, a swinging hall and a warming coolant."""
    time = np.arange(0.0, hours * 3600.0 + every_s / 2, every_s)
    n = np.where(time % 3600.0 < 2400.0, speed, speed / 2.0) if steps else np.full_like(time, speed)
    return pd.DataFrame(
        {
            "time_s": time,
            "speed_rpm": n,
            "T5_degC": 21.0 + np.sin(time / 2000.0),
            "T9_degC": 21.0 + 2.0 * (1.0 - np.exp(-time / 5400.0)),
            "torque_Nm": np.full_like(time, 5.0),
        }
    )


@pytest.fixture(scope="session")
def jig_borer_lumps() -> Machine:
    return read_machine("jig_borer_lumps")


def key_of(name: str) -> str:
    """Return how a machine file names the effect; one that needs a sensor is given T1.

    A name with a driver behind a colon is a key already.
    """
    if ":" in name:
        return name
    return effect_key(name, "T1" if catalogue()[name].on_channel else "")


def with_effects(machine: Machine, *names: str) -> Machine:
    """Return the machine with further effects in force at their nominal values."""
    added = {key_of(n): dict(catalogue()[n.partition(":")[0]].parameters) for n in names}
    return replace(machine, effects=machine.effects | added)


def in_series(machine: Machine, first: str) -> Machine:
    """Return a machine whose motor's jacket gets its coolant from another one."""

    def moved(item: Item) -> Item:
        is_inlet = item.kind == "coolant_flow" and item.refs["between"][0] == "jacket_motor"
        return replace(item, refs={"between": ("jacket_motor", first)}) if is_inlet else item

    return replace(machine, items=tuple(map(moved, machine.items)))
