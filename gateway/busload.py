"""How much of the bus the frames take."""

from __future__ import annotations

from gateway.database import Database

OVERHEAD_BITS = 44
"""A standard frame without its data, start bit to end of frame: given by ISO 11898-1."""
STUFFED_BITS = 34
"""Those of them that bit stuffing reaches, start bit to CRC: given by ISO 11898-1."""
PAUSE_BITS = 3
"""Between two frames: given by ISO 11898-1."""


EXTENSION_BITS = 20
"""What an identifier of 29 bits adds, all of it stuffed: given by ISO 11898-1."""


def frame_bits(size: int, *, stuffed: bool = True, extended: bool = False) -> int:
    """Return the bits that a frame of *size* bytes takes, the pause after it included.

    Parameters
    ----------
    size : int
        Data bytes.
    stuffed : bool
        With as many stuff bits as any content can need; without any otherwise.
    extended : bool
        With an identifier of 29 bits.

    Notes
    -----
    Worst case ``8 n + 44 + floor((34 + 8 n - 1) / 4) + 3``; Davis, Burns, Bril, Lukkien,
    "Controller Area Network (CAN) schedulability analysis", Real-Time Systems 35 (2007), eq. 1.
    """
    data, more = 8 * size, EXTENSION_BITS if extended else 0
    stuffing = (STUFFED_BITS + more + data - 1) // 4 if stuffed else 0
    return data + OVERHEAD_BITS + more + stuffing + PAUSE_BITS


def bus_load(database: Database, *, stuffed: bool = True) -> float:
    """Return the share of the bus that all frames take at its bit rate; 1 is all of it."""
    bits = sum(
        frame_bits(frame.size, stuffed=stuffed, extended=frame.extended) / frame.cycle_s
        for frame in database.frames
    )
    return bits / database.bit_rate
