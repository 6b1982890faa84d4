"""How well the size of an effect is found, where simulator and catalogue mean the same by it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

Effect = Mapping[str, Any]


def _size(effect: Effect) -> float:
    return float(effect["amplitude"])


def _signed(effect: Effect) -> float:
    return _size(effect) * float(effect["more"]["sign"])


COMPARABLE: dict[str, tuple[str, Callable[[Effect], float]]] = {
    "bearing_run_in": ("excess", _size),
    "bearing_stick_slip": ("hold", _size),
    "centrifugal_shift": ("shift", _size),
    "column_bending": ("tilt", _size),
    "coolant_supply_offset": ("offset", _size),
    "coolant_thermostat": ("band", _size),
    # The catalogue states it at a tenth of the machine's 200 Nm, the simulator at 8 Nm.
    "copper_loss": ("power", lambda effect: _size(effect) * (20.0 / 8.0) ** 2),
    "cutting_heat": ("share", _size),
    "fixture_warming": ("growth", _size),
    "forced_convection": ("gain", _size),
    "friction_speed_exponent": ("deviation", _signed),
    "joint_resistance": ("gain", _signed),
    "motor_iron_loss": ("power", _size),
    # Stated at 10 K and at 1 K, with the fourth root between.
    "natural_convection": ("film_at_10_K", lambda effect: _size(effect) * 10.0**0.25),
    "radiation": ("emissivity", _size),
    "sensor_drift": ("rate", lambda effect: _signed(effect) / 8.0),
    "sensor_lag": ("minutes", _size),
    "sensor_offset": ("error", _signed),
    "slow_structure": ("growth", _size),
    "thermal_preload": ("gain", _size),
    "tool_heating": ("conductance", _size),
    "viscosity_temperature": ("slope", _size),
    "windage": ("power", _size),
}
"""The catalogue's amplitude of an effect, and what the simulator's is in its unit.

Left out: ``coolant_degradation``, whose loss and hours stand for each other, and
``uneven_bearing_heating``, which is a temperature here and a share of heat there.
"""


@dataclass(frozen=True)
class Found:
    """An amplitude that was found.

    Attributes
    ----------
    name, parameter : str
    error : float
        Found over true, minus one [1].
    inside : bool
        Whether the interval given holds the true value.
    """

    name: str
    parameter: str
    error: float
    inside: bool


def amplitude_found(effect: Effect, answer: Mapping[str, Any]) -> Found | None:
    """Return how well an effect's amplitude was found; None where it was not, or cannot be said."""
    name = effect["name"]
    added = next((one for one in answer["effects"] if one["name"] == name), None)
    if added is None or name not in COMPARABLE:
        return None
    parameter, in_its_unit = COMPARABLE[name]
    told, true = added["parameters"][parameter], in_its_unit(effect)
    return Found(
        name,
        parameter,
        told["value"] / true - 1.0,
        bool(told["low"] <= true <= told["high"]),
    )
