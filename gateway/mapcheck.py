"""Checks the frames that a map defines, by themselves and against a compensator."""

from __future__ import annotations

import json
from collections.abc import Collection, Iterator
from math import inf
from pathlib import Path
from typing import TYPE_CHECKING, Any

from gateway.database import COMPENSATOR, CYCLE, MACHINE, OFFSETS, Database
from gateway.mapped_signals import own_signals
from gateway.proof import CHALLENGE, ECHO, PROOF
from gateway.protection import PROFILE_1
from measurement.errors import BadInput
from measurement.rig import AXES
from scenarios.fmu_file import compensator_file, read_description
from scenarios.wiring import PROBED, SPEED, check_role, range_of

if TYPE_CHECKING:
    from gateway.mapping import Mapping

NEEDED = {
    MACHINE: ("machine_state", "machine_time", "machine_step", "thermal_state"),
    COMPENSATOR: ("valid", "gateway_state", "status", "bus_fault", "bus_fault_frame"),
}
"""The signals that the two programs themselves need, by the node that sends them."""
LAST = {MACHINE: "machine_time", COMPENSATOR: "answered_time"}
"""The signal that the frame closing a node's cycle must hold."""
Problem = tuple[str, str]
"""A place in the map, or a frame, and the problem with it."""


def check_frames(mapping: Mapping) -> None:
    """Note every problem that makes a map's frames useless for any gateway."""
    form, database = mapping.form, mapping.database
    if not any(database.has(name) for name in OFFSETS):
        mapping.say("outputs", f"no offset is sent: none of {', '.join(OFFSETS)}")
    for name in OFFSETS:
        unsaid = name in form.outputs and form.outputs[name].when_invalid is None
        if unsaid and "valid" not in form.outputs:
            mapping.say(f"outputs.{name}", "needs when_invalid, because no signal carries valid")
    _check_identifiers(mapping)
    for name, value in database.when_invalid.items():
        signal = database.named.get(name)
        if signal is None or signal.is_enumeration:
            continue
        if value < signal.low or value > signal.high:  # NaN, for missing, is neither
            span = f"{signal.low:g} to {signal.high:g} {signal.unit}".rstrip()
            mapping.say(f"outputs.{name}", f"when_invalid = {value:g} is not allowed: {span}")
    problems = _of_cycles(mapping) if database.every_s is None else _of_samples(mapping)
    if database.every_s is not None or not mapping.problems:  # avoid consequential problems
        for place, problem in problems:
            mapping.say(place, problem)


def _check_identifiers(mapping: Mapping) -> None:
    """Note frames that nobody can tell apart."""
    frames = mapping.database.frames
    by_key = {frame.key: frame.name for frame in frames}
    for frame in frames:
        if frame.name != (other := by_key[frame.key]):
            mapping.say(f"frames.{frame.name}", f"has the same identifier as {other}")


def _of_samples(mapping: Mapping) -> Iterator[Problem]:
    form = mapping.form
    for kind, specs in (("inputs", form.inputs), ("outputs", form.outputs)):
        for name in ("machine_time", "machine_step", "answered_time"):
            if name in specs:
                yield f"{kind}.{name}", 'has no meaning with frames = "sampled"'
    if "machine_state" not in form.inputs:
        problem = 'is missing; constant = "running" for a machine that does not say'
        yield "inputs.machine_state", problem
    if not mapping.database.of(MACHINE):
        yield "inputs", "no frame of the machine is left"


def _of_cycles(mapping: Mapping) -> Iterator[Problem]:
    """Yield the reasons why the frames do not form cycles."""
    database, lost = mapping.database, False
    for node, names in NEEDED.items():
        sent = {signal.name for _, signal in database.signals(node)}
        offsets = OFFSETS if node == COMPENSATOR and mapping.form.axes is None else ()
        if missing := [name for name in (*names, *offsets) if name not in sent]:
            lost = True
            yield node, f"sends no signal {', '.join(missing)}"
    if lost:
        return
    ids = [frame.data_id for frame in database.frames if frame.protection.name == PROFILE_1]
    if len(set(ids)) < len(ids):
        yield "E2EDataId", "two frames have the same one"
    if "cold" not in database.signal("thermal_state").codes:
        yield "thermal_state", "has no value named cold"
    proof = database.proof
    if proof is not None and (ECHO not in proof.signals or not database.has(CHALLENGE)):
        yield proof.name, f"needs {ECHO} beside, and a {CHALLENGE}"
    elif proof is not None and len(proof.signals) > 2:
        yield proof.name, f"must hold {ECHO} and {PROOF} alone: a proof is over all other frames"
    yield from _of_nodes(database)


def _of_nodes(database: Database) -> Iterator[Problem]:
    for node, name in LAST.items():
        closing = database.closing(node)
        if name not in closing.signals:
            yield closing.name, f"is {node}'s last frame: it must hold {name}"
        for frame in database.of(node):
            if frame.timeout_s <= frame.cycle_s:
                problem = "is late before the next comes: GenMsgCycleTime must be below E2ETimeout"
                yield frame.name, problem
            if frame.cycle_s != closing.cycle_s:
                yield frame.name, "frames of a node must share a cycle time"
            if frame.cycles != closing.cycles:
                yield frame.name, f"{CYCLE} of a node's frames must be equally long"


def problems_of(mapping: Mapping, fmu: Path, *, machine_clock: bool = False) -> list[BadInput]:
    """Return every reason why a map does not suit a compensator.

    Parameters
    ----------
    mapping : Mapping
        The map, read.
    fmu : Path
        The compensator.
    machine_clock : bool
        Whether the gateway steps by the machine's time.

    Raises
    ------
    BadInput
        If the FMU cannot be read, or is no compensator.
    """
    form = mapping.form
    variables = {variable.name: variable for variable in read_description(fmu).modelVariables}
    check_role("compensator", variables, fmu)
    for name in inputs_of(fmu):
        if name not in form.inputs:
            way = "; --dbc or --map names other frames" if mapping.is_own_form else ""
            mapping.say(f"inputs.{name}", f"is missing: the compensator takes it{way}")
    _check_constants(mapping, variables)
    outputs = {name for name, variable in variables.items() if variable.causality == "output"}
    known = {*outputs, *own_signals(), "trust"}
    for name in form.outputs:
        if name not in known and not mapping.is_own_form:
            mapping.say(f"outputs.{name}", "is not an output of the compensator or the gateway")
    _check_offsets(mapping, outputs, limits_of(fmu).get("offset_um", 0.0))
    _check_speed(mapping, _numbers_in(fmu, "gaussian").get("speed_rpm", 0.0))
    if machine_clock and form.cycle.frames == "sampled":
        mapping.say("cycle.frames", "sampled frames carry no time: --clock machine cannot be used")
    for name, signal in mapping.database.named.items():
        own = str(variables[name].unit or "") if name in variables else ""
        if own and own != signal.unit:
            kind = "outputs" if name in outputs else "inputs"
            told = f"is in {signal.unit}" if signal.unit else "has no unit"
            mapping.say(f"{kind}.{name}", f"{told}; the compensator has it in {own}")
    return mapping.problems


def _check_constants(mapping: Mapping, variables: dict[str, Any]) -> None:
    """Note numbers in place of inputs that are outside the ranges that the compensator declares."""
    for name, substitute in mapping.database.substitutes.items():
        value, taken = substitute.value, variables.get(name)
        if value is None or taken is None:
            continue
        low, high = range_of(taken)
        if not low <= value <= high:
            span = f"{low:g} to {high:g} {taken.unit or ''}".rstrip()
            mapping.say(f"inputs.{name}", f"{value:g} is not allowed: {span}")


def _check_offsets(mapping: Mapping, outputs: Collection[str], limit_um: float) -> None:
    """Note offsets that are not sent, or whose range is less than the compensator's limit [um]."""
    for axis, name in zip(AXES, OFFSETS, strict=True):
        sent, wanted = name in mapping.form.outputs, axis in (mapping.form.axes or AXES)
        if name in outputs and wanted and not sent:
            mapping.say(f"outputs.{name}", "is missing: the compensator sends it; see axes")
        elif sent and not wanted:
            mapping.say(f"outputs.{name}", f"is sent, and axes has no {axis}")
        carrying = [s for _, s in mapping.database.signals(COMPENSATOR) if s.name == name]
        low = max((signal.low for signal in carrying), default=-inf)
        high = min((signal.high for signal in carrying), default=inf)
        if low > -limit_um or high < limit_um:
            span = f"{low:g} to {high:g} um"
            text = f"carries {span}; the compensator sends up to {limit_um:g} um either way"
            mapping.say(f"outputs.{name}", text)
        step = max((abs(s.scale) for s in carrying if not s.is_float), default=0.0)
        if 0.0 < limit_um < step:  # 0: the FMU gives no limit
            text = f"has steps of {step:g} um; the compensator sends at most {limit_um:g} um"
            mapping.say(f"outputs.{name}", text)


def _check_speed(mapping: Mapping, usual_rpm: float) -> None:
    """Note a speed whose range is less than the training's RMS speed [rpm]; 0: it is not used."""
    for _, signal in mapping.database.signals(MACHINE):
        reach = max(-signal.low, signal.high)
        if signal.name == SPEED and reach < usual_rpm:
            text = (
                f"carries up to {reach:g} rpm; the compensator was trained at {usual_rpm:.0f} rpm "
                "RMS: use --map with a wider signal, or fit without speed (fit --no-speed)"
            )
            mapping.say(f"inputs.{SPEED}", text)


def inputs_of(fmu: Path) -> list[str]:
    """Return the real inputs of a compensator, except those for a probe.

    Parameters
    ----------
    fmu : Path
        The compensator.
    """
    variables = read_description(fmu).modelVariables
    given = [variable.name for variable in variables if variable.causality == "input"]
    return [name for name in given if not name.startswith(PROBED)]


def limits_of(fmu: Path) -> dict[str, float]:
    """Return the limits of a compensator; empty if its FMU does not give them.

    Parameters
    ----------
    fmu : Path
        The compensator.
    """
    return _numbers_in(fmu, "limits")


def _numbers_in(fmu: Path, table: str) -> dict[str, float]:
    """Return the numbers in a table of a compensator's file; empty if there is none."""
    try:
        entries = json.loads(compensator_file(fmu) or "")[table].items()
    except (KeyError, ValueError, TypeError, AttributeError):
        return {}
    return {name: float(value) for name, value in entries if isinstance(value, int | float)}
