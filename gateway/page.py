"""The frames as rows of text, and as tables for a terminal."""

from __future__ import annotations

from collections.abc import Sequence

from gateway.busload import bus_load, frame_bits
from gateway.database import ERROR, NOT_AVAILABLE, Database, Frame, Signal

FRAME_HEAD = ("Frame", "Id", "From", "Every", "Late after", "Data id", "Bits, worst")
SIGNAL_HEAD = ("Frame", "Signal", "Bits", "Value = raw *", "Range", "Start", "Error", "Missing")


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


def aligned(head: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """Return a table for a terminal."""
    lines = [head, *rows]
    widths = [max(len(line[i]) for line in lines) for i in range(len(head))]
    return "\n".join(
        "  ".join(cell.ljust(width) for cell, width in zip(line, widths, strict=True)).rstrip()
        for line in lines
    )
