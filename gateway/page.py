"""The frames as text: for the terminal, and for ``docs/gateway.md``.

``python -m gateway.page`` writes the generated parts of that page anew. Nothing in them
is typed: they come from the DBC file.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from pathlib import Path

import can

from gateway.busload import bus_load, frame_bits
from gateway.codec import Sender, Value
from gateway.database import COMPENSATOR, ERROR, MACHINE, NOT_AVAILABLE, Database, Frame, Signal
from gateway.dbc import DBC, read_database
from measurement.files import write_atomically

PAGE = Path(__file__).resolve().parents[1] / "docs" / "gateway.md"
FRAME_HEAD = ("Frame", "Id", "From", "Every", "Late after", "Data id", "Bits, worst")
SIGNAL_HEAD = ("Frame", "Signal", "Bits", "Value = raw *", "Range", "Start", "Error", "Missing")
READINGS = (22.98, 21.12, 21.85, 21.77, 21.0, 22.09, 21.97, 21.9, 21.6, 21.72, 22.05)


def frames_text(database: Database) -> str:
    """Return the tables of frames and signals and the bus load, for a terminal.

    Parameters
    ----------
    database : Database
    """
    frames = aligned(FRAME_HEAD, frame_rows(database))
    signals = aligned(SIGNAL_HEAD, signal_rows(database))
    return f"{frames}\n\n{signals}\n\n{load_text(database)}"


def load_text(database: Database) -> str:
    """Return the bus load in a sentence."""
    rate = database.bit_rate
    if database.fd:
        return f"{len(database.frames)} frames; the load of a bus with CAN FD is not computed."
    frames = sum(len(frame.pages) / frame.cycle_s for frame in database.frames)
    most, least = bus_load(database), bus_load(database, stuffed=False)
    return (
        f"{len(database.frames)} frames, {frames:g} a second: at {rate / 1000:g} kbit/s a bus load "
        f"of {100 * most:.2f} % with the most stuff bits that any content can need "
        f"({most * rate:,.0f} bit/s), {100 * least:.2f} % with none."
    )


def frame_rows(database: Database) -> list[tuple[str, ...]]:
    """Return a row of texts for each frame."""
    return [
        (
            frame.name,
            f"0x{frame.frame_id:03X}",
            frame.sender,
            "on demand" if frame.event else f"{frame.cycle_s * 1e3:g} ms",
            " " if frame.event else f"{frame.timeout_s * 1e3:g} ms",
            f"0x{frame.data_id:04X}",
            str(frame_bits(frame.message.length)),
        )
        for frame in database.frames
    ]


def signal_rows(database: Database) -> list[tuple[str, ...]]:
    """Return a row of texts for each signal but CRC and counter."""
    return [
        _signal_row(frame, signal) for frame in database.frames for signal in frame.signals.values()
    ]


def _signal_row(frame: Frame, signal: Signal) -> tuple[str, ...]:
    first = frame.message.get_signal_by_name(signal.name).start
    codes = signal.codes
    start = next((n for n, raw in codes.items() if raw == signal.start), "").replace("_", " ")
    plain = f"{signal.start * signal.scale + signal.offset:g}"
    value = "named" if signal.is_enumeration else scaling(signal)
    span = "named values" if signal.is_enumeration else f"{signal.low:g} to {signal.high:.10g}"
    return (
        frame.name,
        signal.name,
        f"{first} to {first + signal.bits - 1}",
        value,
        f"{span} {signal.unit}".strip(),
        start or plain,
        str(codes.get(ERROR, "")),
        str(codes.get(NOT_AVAILABLE, "")),
    )


def scaling(signal: Signal) -> str:
    """Return scale and offset as a table shows them."""
    return f"{signal.scale:g}" + (f" {signal.offset:+g}" if signal.offset else "")


def named_rows(database: Database) -> list[tuple[str, ...]]:
    """Return a row for each signal with named values: the signal, and its values."""
    enumerations = {
        signal.name: signal
        for frame in database.frames
        for signal in frame.signals.values()
        if signal.is_enumeration
    }
    return [
        (name, ", ".join(f"{raw} {word}" for word, raw in signal.named.items()))
        for name, signal in enumerations.items()
    ]


def session_lines(database: Database, channel: str = "vcan0") -> list[str]:
    """Return the lines that candump prints for a cycle and its answer."""
    return [
        f"  {channel}  {message.arbitration_id:03X}   [{len(message.data)}]  "
        + " ".join(f"{byte:02X}" for byte in message.data)
        for message in session_messages(database)
    ]


def session_messages(database: Database) -> list[can.Message]:
    """Return the messages of a cycle and its answer."""
    readings: dict[str, Value] = {f"T{n}": value for n, value in enumerate(READINGS, 1)}
    readings |= {"speed": 4000.0, "tool_length": 100.0, "offset_use": "following"}
    readings["thermal_state"] = "warm"
    readings |= {"machine_state": "running", "machine_time": 1200.0, "machine_step": 0.1}
    answer: dict[str, Value] = {"dX": -1.7, "dY": -2.26, "dZ": 6.42, "valid": "valid"}
    answer |= {"elongation": 6.42, "yaw": 14.32, "pitch": 10.84, "status": "ok"}
    for axis, slope in (("X", -14.32), ("Y", -10.84), ("Z", 0.0)):
        answer[f"d{axis}_at_tool_length"] = answer[f"d{axis}"]
        answer |= {f"d{axis}_per_tool_length": slope, f"d{axis}_tool_length": 100.0}
    answer |= {"challenge": 0x4F1C2A73, "freshness": "proven"}
    answer |= {"gateway_state": "running", "status_sensor": 0.0, "bus_fault": "none"}
    # The answer names the time that it answers by the low 16 bits of its milliseconds.
    answer |= {"bus_fault_frame": 0.0, "answered_time": (1_200_000 % 65536) / 1e3}
    return [
        *Sender(database, MACHINE).messages(readings, 0x5D03917B),
        *Sender(database, COMPENSATOR).messages(answer),
    ]


def updated(text: str, database: Database) -> str:
    """Return the page with its generated parts made anew.

    Raises
    ------
    ValueError
        If the page lacks the marks of a part.
    """
    parts = {
        "frames": _markdown(FRAME_HEAD, frame_rows(database)) + f"\n\n{load_text(database)}",
        "values": _markdown(("Signal", "Values"), named_rows(database)),
    }
    for name, body in parts.items():
        pattern = rf"(<!-- begin {name}[^>]*-->\n).*?(<!-- end {name} -->)"
        found = re.search(pattern, text, re.DOTALL)
        if found is None:
            raise ValueError(f"the page has no part {name}")
        text = f"{text[: found.start()]}{found[1]}{body}\n{found[2]}{text[found.end() :]}"
    return text


def _markdown(head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    lines = [head, ["---"] * len(head), *rows]
    return "\n".join(f"| {' | '.join(cell or ' ' for cell in line)} |" for line in lines)


def aligned(head: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """Return a table for a terminal."""
    lines = [head, *rows]
    widths = [max(len(line[i]) for line in lines) for i in range(len(head))]
    return "\n".join(
        "  ".join(cell.ljust(width) for cell, width in zip(line, widths, strict=True)).rstrip()
        for line in lines
    )


def main() -> None:
    """Write the page anew."""
    write_atomically(PAGE, updated(PAGE.read_text(encoding="utf-8"), read_database(DBC)))


if __name__ == "__main__":
    main()
