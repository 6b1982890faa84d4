"""The parts of a compensator FMU with a CAN terminal: the C twin behind a node of the bus."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from math import nan
from pathlib import Path

from fmu_packaging.bus_terminal import BusFrame, BusTerminal, SignalTerminal
from fmu_packaging.native.build import Native
from fmu_packaging.package import Recipe, slave_of
from fmu_packaging.units import UnitError, base_unit
from fmu_packaging.variables import Variable
from gateway.database import COMPENSATOR, MACHINE, NOT_AVAILABLE, Database, Frame, Signal
from gateway.dbc import DBC
from gateway.mapping import read_database
from gateway.native.generate import node_data
from measurement.errors import BadInput

C_FOLDER = Path(__file__).resolve().parent / "c"
TERMINAL = BusTerminal("CAN", "can")
NOTIFICATIONS = Variable(
    TERMINAL.notifications,
    "boolean",
    "parameter",
    "Whether the bus confirms frames; this node does not wait for that",
)
HEARD = " As the bus brings it"
NOTE = (
    "It is a node of a CAN bus (FMI-LS-BUS 1.0.0, {cut} cut): readings come in frames, and frames "
    "carry the offsets."
)
NO_BUS = "no_bus.c"
"""The source that the node replaces."""
MOST_FRAMES = 64
"""Largest number of frames, one bit of a 64-bit word each: given by C."""


def native_on_bus(
    recipe: Recipe, native: Native, dbc: Path | None = None, *, high: bool = False
) -> Native:
    """Return the parts of a compensator with a CAN terminal.

    The former inputs become outputs, which show the values received in frames.

    Parameters
    ----------
    recipe : Recipe
        The recipe of the compensator's FMU.
    native : Native
        The parts of its C twin.
    dbc : Path, optional
        The frames; by default the gateway's own.
    high : bool
        Whether the signals are variables, instead of frames as bytes.

    Raises
    ------
    BadInput
        If the DBC file cannot be used, or does not carry what the compensator needs.
    """
    database = read_database(dbc or DBC)
    own = [native.variables.get(v.name, v) for v in slave_of(recipe).variables]
    inputs = {variable.name: variable for variable in own if variable.causality == "input"}
    terminal, signals = _signals(database) if high else (None, [NOTIFICATIONS])
    sources = {path.name: path.read_text("utf-8") for path in sorted(C_FOLDER.iterdir())}
    # Signals arrive without delay, so no proof of freshness is needed.
    judged = database.unproven() if high else database
    sources |= node_data(judged, [*own, *signals], terminal)

    def data(variables: Sequence[Variable], guid: str) -> Mapping[str, str]:
        # To the compensator's own C code they are still inputs.
        return native.data([inputs.get(variable.name, variable) for variable in variables], guid)

    heard = {name: replace(v, depends=()) for name, v in native.variables.items()}
    shown = {name: _shown(variable) for name, variable in inputs.items()}
    network = {} if high else {database.path.name: database.path.read_bytes()}
    return replace(
        native,
        program={**native.program, NO_BUS: sources.pop("node.c"), **sources},
        data=data,
        variables={**heard, **shown, **{signal.name: signal for signal in signals}},
        documents={**native.documents, **network},
        note=NOTE.format(cut="high" if high else "low"),
        bus=terminal or TERMINAL,
        derivatives=False,
    )


def _shown(variable: Variable) -> Variable:
    missing = "; NaN: missing" if variable.kind == "real" else ""
    description = f"{variable.description.partition(';')[0]}.{HEARD}{missing}"
    return replace(
        variable,
        causality="output",
        variability="discrete",
        description=description,
        start=None,
        depends_at_start=(),
    )


def _signals(database: Database) -> tuple[SignalTerminal, list[Variable]]:
    """Return the terminal and the variables of all frames, those of a cycle first."""
    path, proof = database.path, database.proof
    if not re.fullmatch(r"[A-Za-z_]\w*", path.stem, re.ASCII):
        problem = "names the bus, so it must have letters, digits and underscores alone"
        raise BadInput(path, "", problem)
    heard = sorted(database.of(MACHINE), key=lambda frame: frame is proof)
    frames = [*heard, *database.events(MACHINE), *database.of(COMPENSATOR)]
    listed = [BusFrame(f.name, (*f.signals, *_protection(f)), f.sender == MACHINE) for f in frames]
    if sum(frame.received for frame in listed) > MOST_FRAMES:
        raise BadInput(path, MACHINE, f"sends more than {MOST_FRAMES} frames")
    terminal = SignalTerminal(path, COMPENSATOR, tuple(listed))
    return terminal, [v for frame in frames for v in _variables(database, terminal, frame)]


def _protection(frame: Frame) -> tuple[str, str, str]:
    """Return the protection signals, which no sender fills, in the order of ``frames.h``."""
    return frame.protection.check, frame.protection.counter, frame.cycle


def _variables(database: Database, terminal: SignalTerminal, frame: Frame) -> Iterator[Variable]:
    judged = frame in database.unproven().of(frame.sender)
    raws = {signal.name: signal for signal in frame.message.signals}
    for name in (*frame.signals, *_protection(frame)):
        signal, raw = frame.signals.get(name), raws[name]
        unit = str(raw.unit or "")
        try:
            base_unit(unit or "1")
        except UnitError as error:
            raise BadInput(database.path, f"{frame.name}.{name}", str(error)) from None
        about = str(raw.comment or f"{name} of {frame.name}").rstrip(".")
        if frame.sender == MACHINE and (signal is None or not judged):
            about += ". Makes no difference here"
        yield Variable(
            terminal.signal(frame.name, name),
            "real",
            "input" if frame.sender == MACHINE else "output",
            about,
            unit,
            start=_start(signal) if frame.sender == MACHINE else None,
            low=None if raw.minimum is None else float(raw.minimum),
            high=None if raw.maximum is None else float(raw.maximum),
            variability="discrete",
            depends_at_start=(),
            clock=terminal.clock(frame.name),
        )


def _start(signal: Signal | None) -> float:
    """Return the value that a receiver assumes before the first frame."""
    if signal is None:
        return 0.0
    missing = signal.start == signal.codes.get(NOT_AVAILABLE)
    return nan if missing else signal.start * signal.scale + signal.offset
