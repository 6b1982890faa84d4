"""The proof that a cycle is fresh: it was made after a recent challenge.

Counters and check values detect damaged cycles, but cannot tell an old cycle from a new one. So
the gateway draws a random number (the challenge) for every answer, and the machine's next cycle
carries a proof over that number and the bytes of all its other frames. The gateway computes the
same proof from the received frames: if both agree, every frame was sent after the number was drawn,
and the gateway's own clock gives the time since then.

Without a key the proof is a CRC-32, which one wrong cycle in 4 thousand million passes. With a key
it is the beginning of an AES-CMAC (RFC 4493), truncated as in AUTOSAR SecOC, which nobody without
the key can compute."""

from __future__ import annotations

import secrets
import stat
import zlib
from collections import deque
from collections.abc import Callable, Iterable, Mapping
from importlib.util import find_spec
from pathlib import Path

from measurement.errors import BadInput

CHALLENGE, ECHO, PROOF, FRESHNESS = "challenge", "echo", "proof", "freshness"
NOT_PROVEN, PROVEN = "not_proven", "proven"
ECHO_BITS = 0xFFFF
"""The part of a challenge that the frame returns: given by its signal."""
LARGEST_ECHO = 65533
"""Given by the signal: the two raw values beyond it mean *error* and *not available*."""
KEY_BYTES = (16, 32)
"""Length of a key, 128 or 256 bits: given by AES; 192 bits are not supported."""


def proof_of(challenge: int, frames: Iterable[bytes], key: bytes | None = None) -> int:
    """Return the proof that a cycle's frames were made after a challenge.

    Parameters
    ----------
    challenge : int
        32 bits.
    frames : iterable of bytes
        The other frames of the cycle, by rising identifier.
    key : bytes, optional
        With a key the proof is a message authentication code.
    """
    data = challenge.to_bytes(4, "little") + b"".join(frames)
    if key is None:
        return zlib.crc32(data)
    from cryptography.hazmat.primitives.ciphers.algorithms import AES
    from cryptography.hazmat.primitives.cmac import CMAC

    code = CMAC(AES(key))
    code.update(data)
    return int.from_bytes(code.finalize()[:4], "little")


def draw() -> int:
    """Return a new challenge."""
    while True:
        challenge = secrets.randbits(32)
        if challenge & ECHO_BITS <= LARGEST_ECHO:
            return challenge


class Challenges:
    """The challenges that are recent enough to be answered.

    Parameters
    ----------
    young_s : float
        Largest age of an answered challenge [s].
    key : bytes, optional
        See `proof_of`.
    new : callable, optional
        Draws a challenge.
    """

    def __init__(
        self, young_s: float, key: bytes | None = None, new: Callable[[], int] = draw
    ) -> None:
        self.young_s, self._key, self._new = young_s, key, new
        self._drawn: deque[tuple[float, int]] = deque()

    def issue(self, now: float) -> int:
        """Return a challenge to send at *now* [s] or soon after."""
        self._forget(now)
        self._drawn.append((now, self._new()))
        return self._drawn[-1][1]

    def _forget(self, now: float) -> None:
        while self._drawn and now - self._drawn[0][0] > self.young_s:
            self._drawn.popleft()

    def proven(self, proof: Mapping[str, float], frames: Iterable[bytes], arrived: float) -> bool:
        """Return whether a cycle was made after a recent challenge.

        Parameters
        ----------
        proof : mapping of str to float
            The cycle's ``echo`` and ``proof``.
        frames : iterable of bytes
            The cycle's other frames.
        arrived : float
            When the cycle's last frame arrived [s].
        """
        content = tuple(frames)
        return any(
            proof.get(ECHO) == challenge & ECHO_BITS
            and proof.get(PROOF) == proof_of(challenge, content, self._key)
            for at, challenge in reversed(self._drawn)
            if arrived - at <= self.young_s
        )


def read_key(path: Path) -> bytes:
    """Read a key: 32 or 64 hexadecimal digits, in a file that only its owner may read.

    Parameters
    ----------
    path : Path
        The file.

    Returns
    -------
    bytes
        The key, 16 or 32 bytes.

    Raises
    ------
    BadInput
        If the file is not a key, or others may read it.
    """
    if find_spec("cryptography") is None:
        raise BadInput("--key", "", "needs cryptography: pip install 'spindle-drift[keys]'")
    try:
        mode = path.stat().st_mode
        text = path.read_text(encoding="ascii").strip()
    except OSError as error:
        raise BadInput(path, "", f"cannot be read: {error.strerror}") from None
    except UnicodeDecodeError:
        text = ""
    if mode & (stat.S_IRWXG | stat.S_IRWXO):
        raise BadInput(path, "", f"can be read by others: chmod 600 {path.name}")
    try:
        key = bytes.fromhex(text)
    except ValueError:
        key = b""
    if len(key) not in KEY_BYTES:
        raise BadInput(path, "", "is not a key: 32 or 64 hexadecimal digits are needed")
    return key
