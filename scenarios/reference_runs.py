"""The runs with which an FMU is tested when it is built."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from typing import Any

from fmu_compensator.runtime.modelfile import Model
from fmu_packaging.arrays import NAME, in_array, temperatures
from fmu_packaging.package import Recipe, slave_of
from fmu_packaging.publish import Reference
from fmu_packaging.variables import START_DEGC, USUAL_TOOL_MM
from plant_model.machine import Machine

REFERENCE_S, REFERENCE_STEP_S = 3600.0, 10.0
"""An hour in steps of ten seconds [s]: set on no data."""


def _warming(time_s: float, start: float, rise: float) -> float:
    return start + rise * (1.0 - math.exp(-time_s / 1200.0))


def _steady(time_s: float, value: float) -> float:
    return value


def _swing(time_s: float, middle: float, swing: float) -> float:
    return middle + swing * math.sin(2.0 * math.pi * time_s / 3600.0)


def _switched(time_s: float, start: float, then: float) -> float:
    return start if time_s < 60.0 else then


def compensator_reference(model: Model) -> Reference:
    """Return a run in which the machine that a compensator was trained on warms up."""
    profiles: dict[str, Any] = {}
    for sensor in model.sensors:
        if model.input_form == "rise":
            start, rise = START_DEGC, 0.6 * max(sensor.trained_high, 0.0)
        else:
            start = sensor.trained_low
            rise = 0.6 * (sensor.trained_high - sensor.trained_low)
        profiles[sensor.name] = partial(_warming, start=start, rise=rise)
    profiles["speed"] = partial(_switched, start=0.0, then=6000.0)
    profiles["tool_length"] = partial(_steady, value=model.limits.judged_tool())
    return Reference(profiles, REFERENCE_S, REFERENCE_STEP_S)


def with_array(reference: Reference, recipe: Recipe) -> Reference:
    """Return a run whose temperatures are one array, with a value for every step.

    Parameters
    ----------
    reference : Reference
    recipe : Recipe
        Recipe of the FMU.

    Raises
    ------
    NativeError
        If the temperatures cannot be an array.
    """
    variables = slave_of(recipe).variables
    in_array(variables)
    members = [v.name for v in temperatures(variables) if v.name in reference.profiles]
    if not members:
        return reference
    rows = [reference.profiles[name] for name in members]
    others = {name: p for name, p in reference.profiles.items() if name not in members}
    array = partial(_together, profiles=rows)
    return replace(reference, profiles={NAME: array, **others}, every_s=reference.step_s)


def _together(time_s: float, profiles: Sequence[Any]) -> tuple[float, ...]:
    return tuple(profile(time_s) for profile in profiles)


def plant_reference(machine: Machine) -> Reference:
    """Return a run in which a spindle starts to turn and the hall's temperature oscillates."""
    profiles: dict[str, Any] = {}
    for entry in machine.inputs:
        start = entry.default or 0.0
        if entry.is_boundary:
            middle = min(max(START_DEGC, entry.low + 1.0), entry.high - 1.0)
            profiles[entry.name] = partial(_swing, middle=middle, swing=1.0)
        else:
            then = start + 0.3 * (entry.high - start)
            profiles[entry.name] = partial(_switched, start=start, then=then)
    profiles["tool_length"] = partial(_steady, value=USUAL_TOOL_MM)
    for axis in "XYZ":
        profiles[f"d{axis}"] = partial(_swing, middle=0.0, swing=5.0)
    return Reference(profiles, REFERENCE_S, REFERENCE_STEP_S)
