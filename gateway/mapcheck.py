"""Checks a map against its compensator before the bus is opened."""

from __future__ import annotations

import json
import zipfile
from pathlib import Path
from typing import Any

from fmpy import read_model_description

from fmu_compensator.runtime.fmi_slave import MODEL_FILE
from gateway.mapping import Mapping
from measurement.errors import BadInput, one_line
from scenarios.wiring import PROBED


def problems_of(mapping: Mapping, fmu: Path, *, machine_clock: bool = False) -> list[BadInput]:
    """Return every reason why a map cannot serve a compensator.

    Parameters
    ----------
    mapping : Mapping
        The map, read.
    fmu : Path
        The compensator.
    machine_clock : bool
        Whether the gateway is to step by the machine's time.

    Raises
    ------
    BadInput
        If the FMU cannot be read.
    """
    named = _variables(fmu)
    inputs, outputs = (
        [name for name, variable in named.items() if variable.causality == causality]
        for causality in ("input", "output")
    )
    taken = [name for name in inputs if not name.startswith(PROBED)]
    mapping.check_compensator(taken, outputs, limits_of(fmu).get("offset_um"))
    if machine_clock and mapping.form.cycle.frames == "sampled":
        mapping.say("cycle.frames", "sampled frames carry no time: --clock machine cannot be used")
    carried = mapping.database.named.items()
    for name, signal in carried:
        own = str(named[name].unit or "") if name in named else ""
        if own and signal.unit and own != signal.unit:
            kind = "inputs" if name in inputs else "outputs"
            mapping.say(f"{kind}.{name}", f"is in {signal.unit}; the compensator has it in {own}")
    return mapping.problems


def _variables(fmu: Path) -> dict[str, Any]:
    try:
        description = read_model_description(str(fmu), validate=False)
    except Exception as error:  # fmpy raises many kinds
        raise BadInput(fmu, "", f"is not an FMU: {one_line(error)}") from None
    return {variable.name: variable for variable in description.modelVariables}


def inputs_of(fmu: Path) -> list[str]:
    """Return the real inputs of a compensator, without those for a probe.

    Parameters
    ----------
    fmu : Path
        The compensator.
    """
    named = _variables(fmu).items()
    return [n for n, v in named if v.causality == "input" and not n.startswith(PROBED)]


def limits_of(fmu: Path) -> dict[str, float]:
    """Return the limits of a compensator, as far as its FMU tells them.

    Parameters
    ----------
    fmu : Path
        The compensator.
    """
    try:
        with zipfile.ZipFile(fmu) as archive:
            table = json.loads(archive.read(f"resources/{MODEL_FILE}"))
        limits = table["limits"].items()
    except (OSError, KeyError, ValueError, TypeError, AttributeError, zipfile.BadZipFile):
        return {}
    return {name: float(value) for name, value in limits if isinstance(value, int | float)}
