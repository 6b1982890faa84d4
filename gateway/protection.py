"""How a frame is protected: by a counter, a check value, both, or not at all.

What each detects:

- a check value (CRC): bits changed behind the CAN controller's own CRC, and senders that do not
  know it;
- a counter: stuck and repeated frames;
- no protection: only that no frame came.

None of them is authentication.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from crccheck.checksum import Checksum8, ChecksumXor8
from crccheck.crc import Crc8Autosar, Crc8SaeJ1850, Crc8Smbus, Crc16Ibm3740

from gateway import e2e

NONE, COUNTER_ONLY, PROFILE_1 = "none", "counter", "e2e_profile_1"
CHECKS: dict[str, tuple[Callable[[bytes], int], int, str]] = {
    "crc8_sae_j1850": (Crc8SaeJ1850.calc, 1, "polynomial 0x1D, start and final XOR 0xFF"),
    "crc8_autosar": (Crc8Autosar.calc, 1, "polynomial 0x2F, start and final XOR 0xFF"),
    "crc8_smbus": (Crc8Smbus.calc, 1, "polynomial 0x07, start and final XOR 0"),
    "crc16_ccitt_false": (Crc16Ibm3740.calc, 2, "polynomial 0x1021, start 0xFFFF, final XOR 0"),
    "sum8": (Checksum8.calc, 1, "the low byte of the sum of all bytes"),
    "xor8": (ChecksumXor8.calc, 1, "all bytes by exclusive or"),
}
"""Check values by name: what computes one, how many bytes it takes, and what it is."""
NAMES = (NONE, COUNTER_ONLY, PROFILE_1, *CHECKS)


@dataclass(frozen=True)
class Protection:
    """The protection of one frame; this base class is no protection.

    Attributes
    ----------
    name : str
        One of `NAMES`.
    counter : str
        The signal that counts; empty for none.
    counters : int
        How many values it has: it runs from 0 to one less.
    """

    name: str = NONE
    counter: str = ""
    counters: int = 1

    @property
    def signals(self) -> tuple[str, ...]:
        """The signals that belong to the protection."""
        return (self.counter,) if self.counter else ()

    @property
    def trust(self) -> str:
        """Whether faults show by check value and counter, by one of them, or by neither."""
        checked, counted = self.name not in (NONE, COUNTER_ONLY), bool(self.counter)
        return "protected" if checked and counted else "partly" if checked or counted else "none"

    def sealed(self, data: bytes) -> bytes:
        """Return a frame's bytes with its check value; the counter is in place already."""
        return data

    def intact(self, data: bytes | bytearray) -> bool:
        """Return whether a frame fits its check value."""
        return True


@dataclass(frozen=True)
class Profile1(Protection):
    """AUTOSAR E2E profile 1: CRC in byte 0, counter in the low nibble of byte 1."""

    check: str = "crc"
    data_id: int = 0

    @property
    def signals(self) -> tuple[str, ...]:
        """The signals that belong to the protection."""
        return (self.check, self.counter)

    def sealed(self, data: bytes) -> bytes:
        """Return a frame's bytes with its CRC."""
        return e2e.protected(data, self.data_id)

    def intact(self, data: bytes | bytearray) -> bool:
        """Return whether a frame fits its CRC."""
        return e2e.intact(data, self.data_id)


@dataclass(frozen=True)
class Checked(Protection):
    """A check value over the data id's bytes and those of the frame, its own place left out.

    Attributes
    ----------
    check : str
        The signal that holds it.
    at : int
        Its first byte in the frame.
    big : bool
        The more significant byte comes first.
    data_id : bytes
        What comes before the frame's own bytes; may be empty.
    """

    check: str = ""
    at: int = 0
    big: bool = False
    data_id: bytes = b""

    @property
    def signals(self) -> tuple[str, ...]:
        """The signals that belong to the protection."""
        return (self.check, *super().signals)

    def _value(self, data: bytes | bytearray) -> bytes:
        calculate, size, _ = CHECKS[self.name]
        rest = bytes(data[: self.at]) + bytes(data[self.at + size :])
        return calculate(self.data_id + rest).to_bytes(size, "big" if self.big else "little")

    def sealed(self, data: bytes) -> bytes:
        """Return a frame's bytes with its check value."""
        value = self._value(data)
        return data[: self.at] + value + data[self.at + len(value) :]

    def intact(self, data: bytes | bytearray) -> bool:
        """Return whether a frame fits its check value."""
        value = self._value(data)
        return bytes(data[self.at : self.at + len(value)]) == value
