"""The bus load of the frames."""

from __future__ import annotations

from gateway.database import Database

OVERHEAD_BITS = 44
"""Bits of a standard frame without its data, start bit to end of frame: given by ISO 11898-1."""
STUFFED_BITS = 34
"""Those of them that are subject to bit stuffing, start bit to CRC: given by ISO 11898-1."""
PAUSE_BITS = 3
"""The pause between two frames: given by ISO 11898-1."""


EXTENSION_BITS = 20
"""Added by a 29-bit identifier, all subject to bit stuffing: given by ISO 11898-1."""


def frame_bits(size: int, *, stuffed: bool = True, extended: bool = False) -> int:
    """Return the length of a frame with *size* data bytes, including the pause after it [bit].

    Parameters
    ----------
    size : int
        Data bytes.
    stuffed : bool
        Whether to count the most stuff bits that any content needs, or none.
    extended : bool
        Whether the identifier has 29 bits.

    Notes
    -----
    Worst case ``8 n + 44 + floor((34 + 8 n - 1) / 4) + 3``; Davis, Burns, Bril, Lukkien,
    "Controller Area Network (CAN) schedulability analysis", Real-Time Systems 35 (2007), eq. 1.
    """
    data, more = 8 * size, EXTENSION_BITS if extended else 0
    stuffing = (STUFFED_BITS + more + data - 1) // 4 if stuffed else 0
    return data + OVERHEAD_BITS + more + stuffing + PAUSE_BITS


def bus_load(database: Database, *, stuffed: bool = True) -> float:
    """Return the share of the bit rate that all frames take; 1 is a full bus."""
    bits = sum(
        frame_bits(frame.size, stuffed=stuffed, extended=frame.extended) * frame.a_second
        for frame in database.frames
    )
    return bits / database.bit_rate
