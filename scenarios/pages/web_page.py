"""The spindle in a web page: plant and compensator in WebAssembly, with sliders, in one file."""

from __future__ import annotations

import base64
import json
import tempfile
from collections.abc import Iterable, Mapping
from pathlib import Path
from types import SimpleNamespace
from typing import Any

from fmu_compensator.runtime.fmi_slave import share_promised, status_meanings
from fmu_compensator.runtime.modelfile import Model, parse_model
from fmu_packaging.native.compilers import NativeError
from fmu_packaging.native.web import WebModule, web_module
from fmu_packaging.variables import Variable
from measurement.errors import BadInput
from plant_model.machine import Machine
from scenarios.building import compensator_recipe, native_of, plant_recipe
from scenarios.fmu_file import MODELS, member
from scenarios.pages.report import STATES, state_of, write_page
from scenarios.scenario import read_scenario
from scenarios.views import MACHINES
from scenarios.wiring import (
    SPEED,
    TOOL_LENGTH,
    Variables,
    Wiring,
    names_of,
    shared_inputs,
    speed_of,
    wire,
)

DAY = "step_speed"
"""The scenario whose speeds are the day's work, one hour each."""
ABOUT = (
    "Machine {machine}, compensator {compensator}. The sources are those of the FMUs in C, "
    "compiled to WebAssembly; with the same inputs they give the FMUs' numbers. "
    "Spindle-drift {version}."
)


def write_web_page(machine: Machine, compensator: Path, path: Path) -> dict[str, int]:
    """Write a page that simulates a machine with a compensator.

    Parameters
    ----------
    machine : Machine
    compensator : Path
        Compensator file.
    path : Path
        Page to write; replaced whole or not at all.

    Returns
    -------
    dict
        ``plant_bytes`` and ``compensator_bytes``, the size of each FMU in the page.

    Raises
    ------
    BadInput, ModelFileError
        If a file cannot be used, the two do not belong together, or there is no compiler for
        WebAssembly.
    CompileError
        If the compiler rejects the sources.
    """
    try:
        return _written(machine, compensator, path)
    except NativeError as error:
        raise BadInput("web", "", str(error).partition(": ")[2]) from None


def write_page_of(plant: Path, compensator: Path, path: Path) -> None:
    """Write the page of two FMUs of this project, from the files that they were made from.

    Parameters
    ----------
    plant, compensator : Path
        In Python or in C.
    path : Path
        Page to write.

    Raises
    ------
    BadInput
        As `write_web_page`, and for an FMU that does not contain that file.
    """
    machine = Machine.from_dict(json.loads(_inside(plant, MACHINES)))
    with tempfile.TemporaryDirectory(prefix="spindle-drift-web-") as work:
        file = Path(work) / "compensator.json"
        file.write_bytes(_inside(compensator, MODELS))
        write_web_page(machine, file, path)


def _inside(fmu: Path, places: Iterable[str]) -> bytes:
    if (data := member(fmu, *places)) is None:
        raise BadInput(fmu, "", "does not carry the file that it was made from")
    return data


def _written(machine: Machine, compensator: Path, path: Path) -> dict[str, int]:
    recipe, _ = plant_recipe(machine, "plant")
    other, _ = compensator_recipe(compensator, "compensator", native=True)
    model = parse_model(compensator.read_text("utf-8"), str(compensator))
    plant = web_module(recipe, native_of(recipe))
    sender = web_module(other, native_of(other, compensator))
    ends = _as_fmpy(plant), _as_fmpy(sender)
    wiring = _wiring(*ends, compensator)
    about = ABOUT.format(
        machine=machine.name, compensator=model.name, version=recipe.identity.version
    )
    write_page(
        "web/spindle.html",
        path,
        title=machine.title,
        about=about,
        share=share_promised(model),
        told={
            "plant": plant.told(),
            "compensator": sender.told(),
            "wiring": vars(wiring) | {"shared": shared_inputs(*ends)},
            "states": STATES,
            "stateOf": {code: state_of(code) for code in status_meanings()},
            **_controls(machine, model, plant, wiring, speed_of(ends[0]) or ""),
        },
        plant=base64.b64encode(plant.code).decode(),
        compensator=base64.b64encode(sender.code).decode(),
    )
    return {"plant_bytes": len(plant.code), "compensator_bytes": len(sender.code)}


def _wiring(plant: Variables, compensator: Variables, source: Path) -> Wiring:
    """Connect the two as a scenario does; the sliders are its signals."""
    offsets = names_of(compensator, "output")
    signals = [name for name in names_of(plant, "input") if name not in offsets]
    return wire(plant, compensator, [*signals, *shared_inputs(plant, compensator)], source)


def _as_fmpy(module: WebModule) -> Variables:
    return {
        entry.name: SimpleNamespace(
            causality=entry.causality,
            type=entry.kind.capitalize(),
            unit=None if entry.unit == "1" else entry.unit,
            start=entry.start,
        )
        for entry in module.variables
    }


def _controls(
    machine: Machine, model: Model, plant: WebModule, wiring: Wiring, speed: str
) -> Mapping[str, Any]:
    """Return the sliders: range and step, title, and which come first."""
    inputs = {entry.name: entry for entry in plant.variables if entry.name in wiring.driven}
    hall = next(iter(machine.boundary_index))
    sliders = {name: _slider(entry) for name, entry in inputs.items()}
    sliders[TOOL_LENGTH] = (0.0, model.limits.tool_length_mm[1], 5.0)
    titles = {name: name.replace("_", " ").capitalize() for name in inputs}
    titles |= {hall: "Hall", speed: "Speed", TOOL_LENGTH: "Tool length"}
    day = read_scenario(DAY).settings.signals[SPEED]["values"]
    speeds = [min(turns, sliders[speed][1]) for turns in day if speed in inputs]
    return {
        "sliders": sliders,
        "titles": titles,
        "main": [name for name in (speed, TOOL_LENGTH, hall) if name in inputs],
        "speed": speed if speed in inputs else "",
        "hall": hall,
        "programme": {"each_s": 3600, "speeds": speeds},
    }


def _slider(entry: Variable) -> tuple[float, float, float]:
    low, high = float(entry.low or 0.0), float(entry.high or 0.0)
    return low, high, max(10.0 ** (len(str(int(high - low))) - 3), 0.1)
