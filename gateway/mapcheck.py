"""Checks a map against its compensator before the bus is opened."""

from __future__ import annotations

import json
import zipfile
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from fmpy import read_model_description

from fmu_compensator.runtime.fmi_slave import MODEL_FILE
from gateway.mapping import Mapping
from gateway.unit import units_that_differ
from measurement.errors import BadInput
from measurement.files import sha256_of
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
    mapping.check_compensator(taken, outputs, _limits(fmu).get("offset_um"))
    if machine_clock and mapping.form.cycle.frames == "sampled":
        mapping.say("cycle.frames", "sampled frames carry no time: --clock machine cannot be used")
    carried = {s.name: s for frame in mapping.database.frames for s in frame.signals.values()}
    pairs = [(n, str(named[n].unit or ""), s.unit) for n, s in carried.items() if n in named]
    for name, own, bus in units_that_differ(pairs):
        kind = "inputs" if name in inputs else "outputs"
        mapping.say(f"{kind}.{name}", f"is in {bus}; the compensator has it in {own}")
    return mapping.problems


def node_mapping(node_id: int, fmu: Path) -> Mapping:
    """Return the PDOs of a CANopen node that serves a compensator.

    Parameters
    ----------
    node_id : int
        1 to 127.
    fmu : Path
        The compensator.

    Raises
    ------
    BadInput
        If the canopen library is not installed, or the compensator does not fit.
    """
    _need_canopen()
    from gateway.canopen_pdo import canopen_mapping

    return canopen_mapping(node_id, _inputs(fmu))


def node_dictionary(node_id: int, fmu: Path) -> Any:
    """Return the object dictionary of such a node.

    Parameters
    ----------
    node_id : int
        1 to 127.
    fmu : Path
        The compensator.
    """
    from gateway.canopen_pdo import dictionary

    return dictionary(node_id, _inputs(fmu), fmu.name, sha256_of(fmu), _limits(fmu))


def node_eds(node_id: int | None, fmu: Path) -> str:
    """Return the data sheet of such a node.

    Parameters
    ----------
    node_id : int or None
        1 to 127; None where the command line names no node.
    fmu : Path
        The compensator.

    Raises
    ------
    BadInput
        If there is no such node.
    """
    if node_id is None:
        raise BadInput("--eds", "", "needs --canopen: of which node")
    from gateway.canopen_pdo import eds_text

    return eds_text(node_dictionary(node_id, fmu))


def _need_canopen() -> None:
    if find_spec("canopen") is None:
        raise BadInput("--canopen", "", "needs canopen: pip install 'spindle-drift[canopen]'")


def _variables(fmu: Path) -> dict[str, Any]:
    try:
        description = read_model_description(str(fmu), validate=False)
    except Exception as error:  # fmpy raises many kinds
        raise BadInput(fmu, "", f"is not an FMU: {' '.join(str(error).split())}") from None
    return {variable.name: variable for variable in description.modelVariables}


def _inputs(fmu: Path) -> list[str]:
    named = _variables(fmu).items()
    return [n for n, v in named if v.causality == "input" and not n.startswith(PROBED)]


def _limits(fmu: Path) -> dict[str, float]:
    """Return the limits of a compensator, as far as its FMU tells them."""
    try:
        with zipfile.ZipFile(fmu) as archive:
            table = json.loads(archive.read(f"resources/{MODEL_FILE}"))
        limits = table["limits"].items()
    except (OSError, KeyError, ValueError, TypeError, AttributeError, zipfile.BadZipFile):
        return {}
    return {name: float(value) for name, value in limits if isinstance(value, int | float)}
