"""End-to-end protection in the manner of AUTOSAR E2E profile 1.

Byte 0 of a frame is a CRC-8 over the frame's data id and the rest of its bytes: polynomial 0x1D of
SAE J1850 with start value and final XOR of zero, the data id's low byte first. The low nibble of
byte 1 is the alive counter, 0 to 14; 15 is never sent.

Source: AUTOSAR, Specification of SW-C End-to-End Communication Protection Library, profile 1,
data id mode "both".
"""

from __future__ import annotations

from crccheck.crc import Crc8GsmA

COUNTERS = 15
"""The alive counter runs from 0 to 14."""

# crccheck works bit by bit; its results for single bytes make a table, since a CRC is linear.
_TABLE = bytes(Crc8GsmA.calc([byte]) for byte in range(256))


def crc_of(data: bytes | bytearray, data_id: int) -> int:
    """Return the CRC that belongs into byte 0 of *data*, whatever stands there now."""
    crc = _TABLE[_TABLE[data_id & 0xFF] ^ data_id >> 8]
    for byte in data[1:]:
        crc = _TABLE[crc ^ byte]
    return crc


def protected(data: bytes, data_id: int) -> bytes:
    """Return *data* with its CRC; the counter is in place already."""
    return bytes((crc_of(data, data_id),)) + data[1:]


def intact(data: bytes | bytearray, data_id: int) -> bool:
    """Return whether a frame's CRC fits the rest of it."""
    return len(data) > 1 and data[0] == crc_of(data, data_id)
