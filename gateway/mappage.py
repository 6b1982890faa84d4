"""What a map makes of a control's frames, as a table for a terminal."""

from __future__ import annotations

from math import inf

from gateway.database import MACHINE, Frame, Signal
from gateway.mapfile import HOLD, InputMap
from gateway.mapping import Mapping
from gateway.page import aligned, load_text, scaling

HEAD = (
    *("Frame", "Id", "Signal", "Role", "Unit", "Value = raw *", "Range", "Protection"),
    *("Late after", "If missing or not valid"),
)

WIDTH = 60
"""A longer list of values makes the table too wide."""


def map_text(mapping: Mapping) -> str:
    """Return the table of frames and signals, what protects them, and the bus load.

    Parameters
    ----------
    mapping : Mapping
    """
    database = mapping.database
    lines = [aligned(HEAD, map_rows(mapping)), "", load_text(database), ""]
    lines += mapping.unprotected()
    lines += [f"trust: {database.trust}"]
    return "\n".join(lines)


def map_rows(mapping: Mapping) -> list[tuple[str, ...]]:
    """Return a row for each signal in use, and for each input that no frame carries."""
    rows = [
        _row(mapping, frame, signal)
        for frame in mapping.database.frames
        for signal in frame.signals.values()
    ]
    for name, spec in mapping.form.inputs.items():
        if spec.constant is not None:
            rows.append(
                ("", "", "", f"input {name}", "", f"always {spec.constant}", "", "", "", "")
            )
    return rows


def _row(mapping: Mapping, frame: Frame, signal: Signal) -> tuple[str, ...]:
    kind = "input" if frame.sender == MACHINE else "output"
    protection = frame.protection
    page = "" if signal.page is None else f" (page {signal.page})"
    words = signal.is_enumeration
    counter = " + counter" if protection.counter and protection.name != "counter" else ""
    return (
        frame.name,
        f"0x{frame.frame_id:08X}" if frame.extended else f"0x{frame.frame_id:03X}",
        f"{signal.key}{page}",
        f"{kind} {signal.name}",
        signal.unit,
        "named" if words else scaling(signal),
        _words(signal) if words else f"{signal.low:g} to {signal.high:.10g}",
        f"{protection.name}{counter}",
        "never" if frame.timeout_s == inf else f"{frame.timeout_s * 1e3:g} ms",
        _when(mapping, signal.name),
    )


def _words(signal: Signal) -> str:
    text = ", ".join(f"{raw} {word}" for word, raw in signal.named.items())
    return text if len(text) <= WIDTH else f"{len(signal.named)} values"


def _when(mapping: Mapping, name: str) -> str:
    spec: object = mapping.form.inputs.get(name)
    if isinstance(spec, InputMap):
        if spec.when_missing == HOLD:
            return f"held for {spec.hold_s:g} s"
        return str(spec.when_missing)
    output = mapping.form.outputs.get(name)
    return str(output.when_invalid or "") if output is not None else ""
