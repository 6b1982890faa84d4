"""A map held against the compensator that it is to serve, before anything is sent."""

from __future__ import annotations

import json
import zipfile
from pathlib import Path

from fmpy import read_model_description

from fmu_compensator.runtime.fmi_slave import MODEL_FILE
from measurement.errors import BadInput
from scenarios.gateway.mapping import Mapping
from scenarios.gateway.unit import units_that_differ
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
    try:
        description = read_model_description(str(fmu), validate=False)
    except Exception as error:  # fmpy raises many kinds
        raise BadInput(fmu, "", f"is not an FMU: {' '.join(str(error).split())}") from None
    named = {variable.name: variable for variable in description.modelVariables}
    inputs, outputs = (
        [name for name, variable in named.items() if variable.causality == causality]
        for causality in ("input", "output")
    )
    taken = [name for name in inputs if not name.startswith(PROBED)]
    mapping.check_compensator(taken, outputs, _limit_um(fmu))
    if machine_clock and mapping.form.cycle.frames == "sampled":
        mapping.say("cycle.frames", "sampled frames carry no time: --clock machine cannot be used")
    carried = {s.name: s for frame in mapping.database.frames for s in frame.signals.values()}
    pairs = [(n, str(named[n].unit or ""), s.unit) for n, s in carried.items() if n in named]
    for name, own, bus in units_that_differ(pairs):
        kind = "inputs" if name in inputs else "outputs"
        mapping.say(f"{kind}.{name}", f"is in {bus}; the compensator has it in {own}")
    return mapping.problems


def _limit_um(fmu: Path) -> float | None:
    """Return the largest offset that a compensator sends [um]; None if its FMU does not tell."""
    try:
        with zipfile.ZipFile(fmu) as archive:
            table = json.loads(archive.read(f"resources/{MODEL_FILE}"))
        return float(table["limits"]["offset_um"])
    except (OSError, KeyError, ValueError, TypeError, zipfile.BadZipFile):
        return None
