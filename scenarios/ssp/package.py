"""Packs a scenario and its two FMUs into an ``.ssp`` file."""

from __future__ import annotations

import io
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
from fmpy import read_model_description

from fmu_packaging.native.build import Fmi
from fmu_packaging.native.compilers import Compiler
from fmu_packaging.package import archived
from fmu_packaging.units import own_name
from measurement.errors import BadInput
from measurement.files import read_bytes
from scenarios.cosimulation import plant_parameters, signals_over
from scenarios.fmu_file import read_description
from scenarios.scenario import Case, Scenario
from scenarios.signals.base import FloatArray
from scenarios.ssp.signals import signals_fmu
from scenarios.ssp.structure import Component, Connection, Ssp, structure
from scenarios.wiring import TOOL_LENGTH, Variables, check_role, parameter_kind, wire


def case_of(scenario: Scenario, variant: str | None = None) -> Case:
    """Return a variant of a scenario.

    Parameters
    ----------
    scenario : Scenario
    variant : str, optional
        One of the scenario's (default: the first).

    Raises
    ------
    BadInput
        For a replay, which has no plant, and for an unknown variant.
    """
    if scenario.settings.replay is not None:
        raise BadInput(scenario.path, "replay", "has no plant to put into an .ssp")
    names = [case.name for case in scenario.cases]
    if variant is None:
        return scenario.cases[0]
    if variant not in names:
        raise BadInput("--variant", "", f"{variant!r} is not one of {', '.join(names)}")
    return scenario.cases[names.index(variant)]


def ssp_bytes(
    case: Case,
    plant_fmu: Path,
    compensator_fmu: Path | None,
    compilers: Sequence[Compiler] = (),
    ssp: Ssp = 1,
) -> bytes:
    """Return the ``.ssp`` of a case: its FMUs, one that plays its signals, and the connections.

    Parameters
    ----------
    case : Case
        A variant of a scenario.
    plant_fmu : Path
    compensator_fmu : Path or None
        None leaves the offsets at zero.
    compilers : sequence of Compiler
        The FMU that plays the signals is compiled with each, for FMI 3.0 if the plant is; without a
        compiler it is in Python.
    ssp : {1, 2}
        SSP version; FMUs of FMI 3.0 need the second.

    Raises
    ------
    BadInput
        If the case does not fit the FMUs, or has faults or probes, which act between two FMUs.
    """
    source = case.setting.source
    probe = case.settings.compensator.probe if compensator_fmu else None
    for place, given, without in (
        ("faults", case.settings.faults, "--set 'faults=[]' leaves them out"),
        ("compensator.probe", probe, "choose a variant without probes"),
    ):
        if given:
            problem = "cannot be put into an .ssp, whose connections hand values on as they are; "
            raise BadInput(source, place, f"{problem}{without}")
    fmus = {"plant": plant_fmu} | ({"compensator": compensator_fmu} if compensator_fmu else {})
    files = {name: read_bytes(path) for name, path in fmus.items()}
    parts = {name: _component(name, path, ssp) for name, path in fmus.items()}
    plant = parts["plant"].variables
    others = parts["compensator"].variables if "compensator" in parts else None
    time_s: FloatArray = np.arange(case.settings.steps + 1) * case.settings.step_s
    signals = signals_over(case, time_s, plant, others)
    wiring = wire(plant, others, signals, source)
    parts["plant"] = replace(parts["plant"], starts=_plant_starts(case, plant))
    driven = wiring.by_signals
    blind = case.settings.compensator.tool_length_mm
    if others is not None and blind is not None:
        if TOOL_LENGTH not in driven:
            place = "compensator.tool_length_mm"
            raise BadInput(source, place, f"there is no signal {TOOL_LENGTH}")
        driven = tuple(name for name in driven if name != TOOL_LENGTH)
        parts["compensator"] = replace(parts["compensator"], starts={TOOL_LENGTH: blind})
    if signals:
        columns = {_column(name, plant, others): values for name, values in signals.items()}
        fmi: Fmi = 3 if parts["plant"].description.fmiVersion == "3.0" else 2
        files["signals"] = signals_fmu(case, time_s, columns, compilers, fmi).zipped()
        description = read_model_description(io.BytesIO(files["signals"]))
        parts["signals"] = Component("signals", description)
    connections = [
        Connection("plant", "compensator", wiring.measured),
        Connection("compensator", "plant", wiring.offsets),
        Connection("signals", "plant", wiring.driven),
        Connection("signals", "compensator", driven),
    ]
    settings = case.settings
    text = structure(
        f"{settings.name}: {case.title}",
        list(parts.values()),
        [wires for wires in connections if wires.names],
        settings.duration_s,
        settings.step_s,
        ssp,
    )
    fmus_inside = {f"resources/{name}.fmu": data for name, data in files.items()}
    return archived({"SystemStructure.ssd": text, **fmus_inside})


def _component(name: str, path: Path, ssp: Ssp) -> Component:
    component = Component(name, read_description(path, ("2.0", "3.0")[:ssp]))
    check_role(name, component.variables, path)
    return component


def _plant_starts(case: Case, plant: Variables) -> dict[str, float]:
    starts: dict[str, float] = {}
    for name, value in plant_parameters(case, plant).items():
        source = case.setting.source
        kind = parameter_kind("plant", plant, name, value, source, "plant.parameters")
        starts[name] = value if kind == "Real" else bool(value) if kind == "Boolean" else int(value)
    return starts


def _column(name: str, plant: Variables, compensator: Variables | None) -> str:
    variable = plant[name] if name in plant else (compensator or {})[name]
    return f"{name}_{own_name(variable.unit or '1')}"
