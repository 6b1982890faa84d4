"""Connects the FMUs' variables of the same name, and checks what a role requires."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from fmu_packaging.units import own_name
from measurement.errors import BadInput, near, shown
from measurement.rig import AXES

TOOL_LENGTH, SPEED = "tool_length", "speed"
Variables = Mapping[str, Any]
"""The variables of an FMU as described by fmpy, by name and in the FMU's order."""

COMPENSATOR_OUTPUTS = {
    "dX": "Real",
    "dY": "Real",
    "dZ": "Real",
    "valid": "Boolean",
    "status": "Integer",
}

KINDS = {"Float64": "Real", "Int32": "Integer"}
"""FMI 2.0 names of FMI 3.0 types, where they differ."""

PROBED = "measured"
"""Prefix of the inputs that a compensator takes from a probe; without one they stay open."""


@dataclass(frozen=True)
class Wiring:
    """The connections of a scenario's two FMUs and its signals; each entry is a variable's name.

    Attributes
    ----------
    driven : tuple of str
        Inputs of the plant that a signal drives.
    by_signals : tuple of str
        Inputs of the compensator that a signal drives.
    measured : tuple of str
        Inputs of the compensator that are outputs of the plant.
    offsets : tuple of str
        Inputs of the plant that are outputs of the compensator.
    """

    driven: tuple[str, ...]
    by_signals: tuple[str, ...] = ()
    measured: tuple[str, ...] = ()
    offsets: tuple[str, ...] = ()


def names_of(variables: Variables, causality: str, kind: str = "Real") -> list[str]:
    """Return the variables of a causality and a type, in the FMU's order."""
    return [
        name
        for name, variable in variables.items()
        if variable.causality == causality and KINDS.get(variable.type, variable.type) == kind
    ]


def check_role(role: str, variables: Variables, path: Path) -> None:
    """Check that an FMU can play a role: ``plant`` or ``compensator``; others require nothing.

    Parameters
    ----------
    role : str
    variables : dict of str to variable
        The FMU's variables.
    path : Path
        The FMU, for refusals.

    Raises
    ------
    BadInput
        If it lacks a variable that the role requires.
    """
    if role == "compensator":
        lost = [
            name
            for name, kind in COMPENSATOR_OUTPUTS.items()
            if name not in names_of(variables, "output", kind)
        ]
    elif role == "plant":
        inputs, outputs = names_of(variables, "input"), names_of(variables, "output")
        moved = [axis for axis in AXES if f"d{axis}" in inputs]
        if not moved:
            raise BadInput(path, "", "is no plant: it has no input dX, dY or dZ")
        needed = [f"{what}_{axis}" for axis in moved for what in ("drift", "error")]
        lost = [name for name in needed if name not in outputs]
    else:
        lost = []
    if lost:
        raise BadInput(path, "", f"is no {role}: it has no output {', '.join(lost)}")


def parameter_kind(
    role: str,
    variables: Variables,
    name: str,
    value: float,
    source: str | Path,
    place: str,
) -> str:
    """Check a value of a parameter and return the parameter's type: Real, Integer or Boolean.

    Parameters
    ----------
    role : str
        Role of the FMU in the scenario, for refusals.
    variables : dict of str to variable
        The FMU's variables.
    name : str
    value : float
        In the parameter's unit; 0 or 1 for a Boolean.
    source : str or path
        Where the value was given, for refusals.
    place : str
        Place in the source.

    Returns
    -------
    str
        ``Real``, ``Integer`` or ``Boolean``.

    Raises
    ------
    BadInput
        If the FMU has no such parameter, or does not accept the value.
    """
    variable = variables.get(name)
    if variable is None or variable.causality != "parameter" or variable.type == "String":
        parameters = [key for key, v in variables.items() if v.causality == "parameter"]
        problem = f"the {role} FMU has no such parameter{near(name, parameters)}"
        raise BadInput(source, f"{place}.{name}", problem)
    if _outside(variable, value):
        raise BadInput(source, f"{place}.{name}", _refused(role, variable, shown(value)))
    kind: str = KINDS.get(variable.type, variable.type)
    kind = kind if kind in ("Real", "Boolean") else "Integer"
    if kind != "Real" and value != int(value):
        raise BadInput(source, f"{place}.{name}", f"{shown(value)} is not a whole number")
    return kind


def range_of(variable: Any) -> tuple[float, float]:
    """Return the least and the greatest value of an FMU's variable, in its unit."""
    low, high = variable.min, variable.max
    return -np.inf if low is None else float(low), np.inf if high is None else float(high)


def _outside(variable: Any, values: npt.ArrayLike) -> npt.NDArray[np.bool_]:
    """Return which values, in the variable's unit, are outside its range."""
    low, high = range_of(variable)
    return (np.asarray(values) < low) | (np.asarray(values) > high)


def _refused(role: str, variable: Any, value: str) -> str:
    low, high = variable.min, variable.max
    return f"{value} is not allowed: the {role} FMU takes {low} to {high}"


def check_ranges(
    plant: Variables,
    signals: Mapping[str, npt.NDArray[np.floating]],
    time_s: npt.NDArray[np.floating],
    source: str | Path,
) -> None:
    """Check that the plant accepts every value of its signals.

    Parameters
    ----------
    plant : dict of str to variable
    signals : mapping of str to array, shape (points,)
        Each in its input's unit.
    time_s : array, shape (points,)
        [s]
    source : str or path
        The scenario, for refusals.

    Raises
    ------
    BadInput
        With the first value out of range, and its time.
    """
    for name in names_of(plant, "input"):
        for k in np.flatnonzero(_outside(plant[name], signals.get(name, [])))[:1]:
            value = f"{signals[name][k]:g} at {time_s[k]:g} s"
            raise BadInput(source, f"signals.{name}", _refused("plant", plant[name], value))


def speed_of(plant: Variables) -> str | None:
    """Return the plant's spindle speed: ``speed``, or else its only input in r/min."""
    turning = [n for n in names_of(plant, "input") if own_name(plant[n].unit or "1") == "rpm"]
    if SPEED in plant:
        return SPEED
    return turning[0] if len(turning) == 1 else None


def shared_inputs(plant: Variables, compensator: Variables | None) -> dict[str, str]:
    """Return the plant's inputs by those of the compensator that must get the same.

    Their names are equal, except that a plant may have its own name for the spindle speed.
    """
    inputs, wanted = names_of(plant, "input"), names_of(compensator or {}, "input")
    own = {name: speed_of(plant) if name == SPEED else name for name in wanted}
    return {name: same for name, same in own.items() if same in inputs}


def shared_starts(
    plant: Variables, compensator: Variables | None, signals: Collection[str]
) -> dict[str, float]:
    """Return the plant's start values of inputs that both FMUs have and no signal drives.

    Each FMU has its own start value, but both must get the same tool, for example.
    """
    both = shared_inputs(plant, compensator).values()
    return {name: float(plant[name].start or 0.0) for name in both if name not in signals}


def check_signals(
    plant: Variables, compensator: Variables | None, signals: Iterable[str], source: str | Path
) -> None:
    """Check that every signal of a scenario drives an input.

    Raises
    ------
    BadInput
        For a signal that neither FMU takes, or for a second speed.
    """
    inputs = names_of(plant, "input")
    others = {*names_of(compensator or {}, "input")} - {*shared_inputs(plant, compensator)}
    for name in signals:
        if name not in inputs and name not in others:
            raise BadInput(
                source,
                f"signals.{name}",
                f"is not an input of the plant FMU: {', '.join(inputs)}; correct it, or remove it"
                " from a copy of the scenario",
            )


def wire(
    plant: Variables, compensator: Variables | None, signals: Collection[str], source: str | Path
) -> Wiring:
    """Connect a plant, a compensator if there is one, and signals, by equal names.

    Parameters
    ----------
    plant, compensator : dict of str to variable
    signals : collection of str
        The scenario's signals, including `shared_inputs`.
    source : str or path
        The scenario, for refusals.

    Returns
    -------
    Wiring

    Raises
    ------
    BadInput
        If an input of the compensator is left open, a signal and the compensator drive the same
        input, or connected variables differ in unit.
    """
    inputs = names_of(plant, "input")
    driven = tuple(name for name in inputs if name in signals)
    if compensator is None:
        return Wiring(driven)
    offered = names_of(compensator, "output")
    offsets = tuple(name for name in inputs if name in offered)
    for name in offsets:
        if name in signals:
            raise BadInput(
                source,
                f"signals.{name}",
                "is what the compensator sends; disable the compensator to set it by hand",
            )
    readings = names_of(plant, "output")
    needed = names_of(compensator, "input")
    by_signals = tuple(name for name in needed if name in signals)
    measured = tuple(name for name in needed if name in readings and name not in by_signals)
    connected = {*by_signals, *measured}
    lost = [name for name in needed if name not in connected and not name.startswith(PROBED)]
    if lost:
        raise BadInput(
            source,
            "compensator.fmu",
            f"needs {', '.join(lost)}, which is neither an output of the plant nor a signal",
        )
    _same_units(measured, ("plant", plant), ("compensator", compensator), source)
    _same_units(offsets, ("compensator", compensator), ("plant", plant), source)
    return Wiring(driven, by_signals, measured, offsets)


def _same_units(
    names: Iterable[str],
    start: tuple[str, Variables],
    end: tuple[str, Variables],
    source: str | Path,
) -> None:
    for name in names:
        first, second = start[1][name].unit, end[1][name].unit
        if first and second and first != second:
            raise BadInput(
                source,
                "compensator.fmu",
                f"{name} is in {first} in the {start[0]} and in {second} in the {end[0]}",
            )
