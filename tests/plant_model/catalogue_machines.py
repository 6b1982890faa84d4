"""Machines that the catalogue's tests put effects into, and what they ask of an effect."""

from typing import Any

import numpy as np
import pandas as pd

from plant_model.effects import Effect, catalogue
from plant_model.machine import Machine
from plant_model.machine_file import machine_from_table
from plant_model.parameters import FloatArray, Parameter, Values
from plant_model.simulate import Simulation, simulate
from tests.plant_model.conftest import key_of, with_effects

TEMPERATURES = [f"T{i}" for i in range(1, 12)]


def number(value: float, unit: str) -> dict[str, Any]:
    low, high = sorted((0.8 * value, 1.25 * value))
    return Parameter(value, unit, low, high, "test").to_dict()


def numbers_of(numbers: dict[str, tuple[float, str]]) -> dict[str, Any]:
    return {key: number(*pair) for key, pair in numbers.items()}


def link(kind: str, first: str, second: str, **numbers: tuple[float, str]) -> dict[str, Any]:
    return {"kind": kind, "between": [first, second]} | numbers_of(numbers)


def item(kind: str, name: str, rest: dict[str, str], **numbers: tuple[float, str]) -> Any:
    return {"kind": kind, "name": name} | rest | numbers_of(numbers)


def lathe() -> Machine:
    """Return a lathe of unusual names, without torque, coolant and tool, with a direct rig."""
    capacities = {"quill": 5e3, "ring": 500.0, "race": 700.0, "cage": 4e3, "winding": 6e3}
    capacities |= {"headstock": 6e4, "bed": 5e5}
    expansion = (11.5, "1e-6/K")
    segment = {"start": (0.0, "mm"), "end": (400.0, "mm"), "expansion": expansion}

    film = (8.0, "W/(m2 K)")

    def part(kind: str, node: str, **numbers: tuple[float, str]) -> dict[str, Any]:
        return {"kind": kind, "name": f"{kind}_{node}", "nodes": [node]} | numbers_of(numbers)

    rings = {"inner": "ring", "outer": "race", "driven_by": "speed"}
    bearing = {"mean_diameter": (120.0, "mm"), "f0": (2.0, "1"), "f1": (0.001, "1")}
    bearing |= {"preload": (1000.0, "N"), "viscosity": (20.0, "mm2/s")}
    motor = {"rotor": "cage", "stator": "winding", "driven_by": "speed"}
    laws = "conduction surface_convection bearing_friction motor_loss thermal_expansion"
    table = bare_table() | {
        "name": "lathe",
        "nodes": [
            {"name": name, "capacity": number(value, "J/K"), "start": "hall"}
            for name, value in capacities.items()
        ],
        "links": [
            link("contact", "ring", "race", conductance=(15.0, "W/K")),
            link("contact", "headstock", "race", conductance=(60.0, "W/K")),
            link("contact", "ring", "quill", conductance=(60.0, "W/K")),
            link("contact", "cage", "quill", conductance=(20.0, "W/K")),
            link("contact", "winding", "headstock", conductance=(50.0, "W/K")),
            link("conduction", "headstock", "bed", conductance=(30.0, "W/K")),
            link("convection", "headstock", "hall", area=(0.8, "m2"), coefficient=film),
            link("convection", "bed", "hall", area=(3.0, "m2"), coefficient=film),
        ],
        "sources": [
            item("bearing", "front", rings, **bearing),
            item("motor", "drive", motor, loss=(60.0, "W/(1000 r/min)")),
        ],
        "structure": [
            item("located", "front", {}, at=(350.0, "mm"), gauge_line=(400.0, "mm")),
            part("shaft", "quill", **segment),
            part("housing", "headstock", **segment),
            part("member", "bed", length=(300.0, "mm"), expansion=expansion, x=(0.5, "1")),
        ],
        "sensors": [{"name": "T1", "of": "race"}, {"name": "T2", "of": "hall"}],
        "rig": {"kind": "direct", "axes": {"px": {"axis": "X"}, "pz": {"axis": "Z", "sign": -1}}},
        "effects": {law: {} for law in laws.split()},
    }
    return machine_from_table(table, "lathe.toml")


def bare_table() -> dict[str, Any]:
    """Return a machine of one node and nothing that most effects could act on, as its table."""
    return {
        "format": 1,
        "name": "bare",
        "title": "",
        "inputs": {
            "speed": {"unit": "rpm", "column": "speed_rpm", "low": 0.0, "high": 4000.0},
            "hall": {"unit": "degC", "column": "hall_degC", "low": -20.0, "high": 60.0},
        },
        "nodes": [{"name": "lump", "capacity": number(1e4, "J/K"), "start": "hall"}],
        "links": [],
        "sensors": [{"name": "T1", "of": "lump"}],
        "rig": {"kind": "direct", "axes": {"px": {"axis": "X"}, "pz": {"axis": "Z"}}},
        "effects": {"bearing_friction": {}},
    }


def bare() -> Machine:
    """Return it."""
    return machine_from_table(bare_table(), "bare.toml")


def steady(speed: float, hours: float, hall: float = 21.0, coolant: float = 21.0) -> pd.DataFrame:
    time = np.arange(0.0, hours * 3600.0 + 1.0, 60.0)
    return pd.DataFrame(
        {"time_s": time, "speed_rpm": speed, "T5_degC": hall, "T9_degC": coolant, "torque_Nm": 0.0}
    )


def made(machine: Machine, name: str, **own: float) -> tuple[Machine, Effect]:
    """Return the machine with the effect at some values, and the effect itself.

    *name* may hold a driver behind a colon.
    """
    moved = {f"effects.{key_of(name)}.{key}": value for key, value in own.items()}
    with_it = with_effects(machine, name).with_values(moved)
    only, _, channel = key_of(name).partition(":")
    return with_it, catalogue()[only](with_it, Values(with_it.parameters), channel)


def heat_of(
    effect: Effect,
    speed: float,
    temperatures: dict[str, float] | None = None,
    states: list[float] | None = None,
    **inputs: float,
) -> dict[str, float]:
    """Return the heat of an effect by node [W]; every temperature not given is 20 degC."""
    machine = effect.machine
    values = {entry.name: np.array([20.0]) for entry in machine.inputs if entry.is_boundary}
    values |= {"torque": np.zeros(1), "speed": np.array([speed])}
    values |= {name: np.array([value]) for name, value in inputs.items()}
    now = np.array([[[(temperatures or {}).get(node.name, 20.0) for node in machine.nodes]]])
    own = None if states is None else np.array([[states]])
    out = np.zeros_like(now)
    effect.heat(values, now, own, out)
    for entry in effect.constant_exchanges:
        assert not entry.boundary
        assert not entry.one_way
        flow = entry.conductance * (now[..., entry.other] - now[..., entry.node])
        out[..., entry.node] += flow
        out[..., entry.other] -= flow
    return {node.name: float(out[0, 0, i]) for i, node in enumerate(machine.nodes)}


def change(
    machine: Machine, name: str, inputs: pd.DataFrame, **own: float
) -> tuple[dict[str, FloatArray], Simulation, Simulation]:
    """Return what the effect changes in every reading, and the simulations with and without."""
    with_it, without = (
        simulate(entry, inputs) for entry in (made(machine, name, **own)[0], machine)
    )
    moved = {key: with_it.readings[key][0] - value[0] for key, value in without.readings.items()}
    return moved, with_it, without
