"""Tables of the frames as text, for the documentation and for a terminal."""

from __future__ import annotations

from collections.abc import Sequence
from math import inf

from gateway.busload import bus_load
from gateway.database import ERROR, MACHINE, NOT_AVAILABLE, Database, Frame, Signal
from gateway.mapfile import HOLD, InputMap
from gateway.mapping import Mapping

HEAD = (
    *("Frame", "Id", "Signal", "Role", "Unit", "Value = raw *", "Range", "Protection"),
    *("Late after", "If missing or not valid"),
)


def frames_text(mapping: Mapping) -> str:
    """Return the table of frames and signals, their protection, and the bus load.

    Parameters
    ----------
    mapping : Mapping
    """
    database = mapping.database
    lines = [aligned(HEAD, signal_rows(mapping)), "", *map(": ".join, named_rows(database)), ""]
    lines += [load_text(database), ""]
    lines += mapping.unprotected()
    lines += [f"trust: {database.trust}"]
    return "\n".join(lines)


def signal_rows(mapping: Mapping) -> list[tuple[str, ...]]:
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
        f"{len(signal.named)} values" if words else f"{signal.low:g} to {signal.high:.10g}",
        f"{protection.name}{counter}",
        "never" if frame.timeout_s == inf else f"{frame.timeout_s * 1e3:g} ms",
        _when(mapping, signal.name),
    )


def _when(mapping: Mapping, name: str) -> str:
    spec: object = mapping.form.inputs.get(name)
    if isinstance(spec, InputMap):
        if spec.when_missing == HOLD:
            return f"held for {spec.hold_s:g} s"
        return str(spec.when_missing)
    output = mapping.form.outputs.get(name)
    return str(output.when_invalid or "") if output is not None else ""


def load_text(database: Database) -> str:
    """Return the bus load as a sentence."""
    rate = database.bit_rate
    if database.fd:
        return f"{len(database.frames)} frames; the load of a bus with CAN FD is not computed."
    frames = sum(frame.a_second for frame in database.frames)
    most, least = bus_load(database), bus_load(database, stuffed=False)
    unknown = [f.name for f in database.frames if f.cycle_s == inf and not f.event]
    left_out = f" Without {', '.join(unknown)}, of unknown period." if unknown else ""
    return (
        f"{len(database.frames)} frames, {frames:g} a second: at {rate / 1000:g} kbit/s a bus load "
        f"of {100 * most:.2f} % with the most stuff bits that any content can need "
        f"({most * rate:,.0f} bit/s), {100 * least:.2f} % with none.{left_out}"
    )


def scaling(signal: Signal) -> str:
    """Return scale and offset for a table."""
    return f"{signal.scale:g}" + (f" {signal.offset:+g}" if signal.offset else "")


def named_rows(database: Database) -> list[tuple[str, ...]]:
    """Return a row for each signal with named values: the signal and its values."""
    rows = {}
    for frame in database.frames:
        for signal in frame.signals.values():
            choices = dict(frame.message.get_signal_by_name(signal.key).choices or {})
            words = {raw: str(word) for raw, word in choices.items()}
            words |= {raw: word for word, raw in signal.named.items()}
            named = {raw: word for raw, word in words.items() if word not in (ERROR, NOT_AVAILABLE)}
            if len(named) > 1:
                rows[signal.name] = ", ".join(f"{raw} {word}" for raw, word in named.items())
    return list(rows.items())


def aligned(head: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """Return a table for a terminal."""
    lines = [head, *rows]
    widths = [max(len(line[i]) for line in lines) for i in range(len(head))]
    return "\n".join(
        "  ".join(cell.ljust(width) for cell, width in zip(line, widths, strict=True)).rstrip()
        for line in lines
    )
