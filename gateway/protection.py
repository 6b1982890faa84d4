"""How a frame is protected: by a counter, a check value, both, or not at all.

What each detects:

- a check value (CRC): bits changed outside the reach of the CAN controller's own CRC, and senders
  that do not know it;
- a counter: stuck and repeated frames;
- no protection: only missing frames.

None of them is authentication.

The gateway's own frames have both, by AUTOSAR E2E profile 1. Byte 0 is a CRC-8 over the data id
(low byte first) and the rest of the frame; the low nibble of byte 1 is the counter, 0 to 14.
Source: AUTOSAR, Specification of SW-C End-to-End Communication Protection Library, profile 1, data
id mode "both".
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from crccheck.checksum import Checksum8, ChecksumXor8
from crccheck.crc import Crc8Autosar, Crc8GsmA, Crc8SaeJ1850, Crc8Smbus, Crc16Ibm3740

NONE, COUNTER_ONLY, PROFILE_1 = "none", "counter", "e2e_profile_1"
COUNTERS = 15
"""Number of counter values: given by AUTOSAR's profile 1."""
# crccheck works bit by bit, which is slow; a CRC is linear, so a table of single bytes suffices.
_TABLE = bytes(Crc8GsmA.calc([byte]) for byte in range(256))


def _profile_1_crc(data: bytes) -> int:
    crc = 0
    for byte in data:
        crc = _TABLE[crc ^ byte]
    return crc


CHECKS: dict[str, tuple[Callable[[bytes], int], int]] = {
    PROFILE_1: (_profile_1_crc, 1),
    "crc8_sae_j1850": (Crc8SaeJ1850.calc, 1),
    "crc8_autosar": (Crc8Autosar.calc, 1),
    "crc8_smbus": (Crc8Smbus.calc, 1),
    "crc16_ccitt_false": (Crc16Ibm3740.calc, 2),
    "sum8": (Checksum8.calc, 1),
    "xor8": (ChecksumXor8.calc, 1),
}
"""Check values by name: the function that computes one, and its length [byte]."""
NAMES = (NONE, COUNTER_ONLY, *CHECKS)


@dataclass(frozen=True)
class Protection:
    """The protection of one frame; by default none.

    Attributes
    ----------
    name : str
        One of `NAMES`.
    counter : str
        The counter signal; empty for none.
    counters : int
        Number of its values, which begin at 0.
    check : str
        The signal with the check value over the bytes of the data id and the frame, without its
        own; empty for none.
    at : int
        The check value's first byte in the frame.
    big : bool
        Whether the check value's more significant byte comes first.
    data_id : bytes
        Bytes that precede the frame's own in the check value; may be empty.
    """

    name: str = NONE
    counter: str = ""
    counters: int = 1
    check: str = ""
    at: int = 0
    big: bool = False
    data_id: bytes = b""

    @property
    def signals(self) -> tuple[str, ...]:
        """The signals that belong to the protection."""
        return tuple(signal for signal in (self.check, self.counter) if signal)

    @property
    def trust(self) -> str:
        """How faults are detected: by check value and counter, by one of them, or by neither."""
        return ("none", "partly", "protected")[len(self.signals)]

    def _value(self, data: bytes | bytearray) -> bytes:
        calculate, size = CHECKS[self.name]
        rest = bytes(data[: self.at]) + bytes(data[self.at + size :])
        return calculate(self.data_id + rest).to_bytes(size, "big" if self.big else "little")

    def sealed(self, data: bytes) -> bytes:
        """Return a frame's bytes with its check value; the counter must already be in place."""
        if not self.check:
            return data
        value = self._value(data)
        return data[: self.at] + value + data[self.at + len(value) :]

    def intact(self, data: bytes | bytearray) -> bool:
        """Return whether a frame matches its check value."""
        if not self.check:
            return True
        value = self._value(data)
        return bytes(data[self.at : self.at + len(value)]) == value


def profile_1(data_id: int, counter: str = "counter", check: str = "crc") -> Protection:
    """Return the protection by AUTOSAR E2E profile 1 with a 16-bit data id."""
    return Protection(
        PROFILE_1, counter, COUNTERS, check, data_id=(data_id & 0xFFFF).to_bytes(2, "little")
    )
