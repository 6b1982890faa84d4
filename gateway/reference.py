"""The cold state that drift is counted from, and what proves it.

A compensator takes the first temperatures that it is given as those of the cold machine. If started
in the middle of a warm-up, it would be wrong by all the drift so far, and nothing in its inputs
would show that. So it gets no reading before there is one of these proofs:

- the state of a gateway that ran until shortly before;
- a machine that reports that it is cold (``thermal_state``);
- temperatures that have stayed close to the ambient temperature for a while;
- a user who declares the machine cold.

Temperatures that are close together prove nothing unless one of them is the ambient temperature: a
warm spindle that cools evenly looks the same.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from math import isfinite, nan

from gateway.timebase import WORD_HOLDS_S

SAID = "the user says that the machine is cold"


@dataclass(frozen=True)
class Proof:
    """The accepted proofs that the machine is cold.

    Attributes
    ----------
    said : bool
        The user confirms that the machine is cold: count the drift from its first readings.
    ambient : str
        Ambient temperature input: a machine whose temperatures stay near it is cold.
    band_k : float
        Largest difference between the temperatures, and largest change of each [K].
    time_s : float
        How long they must stay in this band, in the compensator's time [s].
    """

    said: bool = False
    ambient: str = ""
    band_k: float = 1.0
    time_s: float = 1800.0


class Reference:
    """Waits for a proof that the machine is cold.

    Parameters
    ----------
    proof : Proof
        The accepted proofs.
    temperatures : sequence of str
        The temperature inputs.

    Attributes
    ----------
    known : str
        The present proof that the machine is cold, as text; empty if there is none.
    """

    def __init__(self, proof: Proof, temperatures: Sequence[str]) -> None:
        self._proof, self._temperatures = proof, tuple(temperatures)
        self.known = SAID if proof.said else ""
        self._since_cold_s = float("inf")
        self._first: list[float] = []
        self._together_s = 0.0

    def say_cold(self) -> None:
        """Note that the user declares the machine cold."""
        self._proof = replace(self._proof, said=True)
        self.known = SAID

    def take(self, values: Mapping[str, float], elapsed_s: float, *, cold: bool) -> str:
        """Take in a usable cycle; return the proof that the machine is cold now, as `known`.

        Parameters
        ----------
        values : mapping of str to float
            The readings.
        elapsed_s : float
            The compensator's time since the previous cycle [s].
        cold : bool
            Whether the machine reports that it is cold.
        """
        if self._proof.said:
            return self.known
        self._since_cold_s = 0.0 if cold else self._since_cold_s + elapsed_s
        together = bool(self._proof.ambient) and self._stand_together(values, elapsed_s)
        self.known = ""
        if self._since_cold_s <= WORD_HOLDS_S:
            self.known = "the machine says that it is cold"
        elif together:
            band, minutes = self._proof.band_k, self._proof.time_s / 60.0
            self.known = f"all temperatures are within {band:g} K for {minutes:g} minutes"
        return self.known

    def _stand_together(self, values: Mapping[str, float], elapsed_s: float) -> bool:
        now = [values.get(name, nan) for name in self._temperatures]
        band = self._proof.band_k
        if not all(map(isfinite, now)) or max(now) - min(now) > band:
            self._first = []
            return False
        still = all(abs(a - b) <= band for a, b in zip(now, self._first, strict=False))
        if not self._first or not still or elapsed_s > WORD_HOLDS_S:
            self._first, self._together_s = now, 0.0
            return False
        self._together_s += elapsed_s
        return self._together_s >= self._proof.time_s
