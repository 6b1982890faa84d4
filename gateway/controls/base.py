"""The port that a control plugs into: the same answer, as that control's registers.

A control says which registers an offset goes into, in which unit, and how far one write may change
it. What carries them there (the PLC's program, OPC UA, ADS, FOCAS) belongs to the machine.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import inf, isfinite

from gateway.database import OFFSETS
from measurement.rig import AXES


@dataclass(frozen=True)
class Write:
    """A register to write: its address as the manual writes it, and what goes into it."""

    address: str
    value: float | int | bool


class Control(ABC):
    """A control; one subclass a file.

    Parameters
    ----------
    signs : sequence of int
        1 or -1 for X, Y and Z: what the control subtracts goes in with -1.
    """

    name = ""
    title = ""
    source = ""
    """The manual that it follows."""
    step_um = 1.0
    """What a register's last digit is worth [um]."""
    most_um = inf
    """The largest offset that a register holds [um]."""
    most_at_once_um = inf
    """By how much one write may change it [um]."""

    def __init__(self, signs: Sequence[int] = (1, 1, 1)) -> None:
        self._signs = tuple(signs)
        self._digits = dict.fromkeys(AXES, 0)

    def start(self) -> list[Write]:
        """Return what is written once, before the first offset."""
        return []

    @abstractmethod
    def write(self, axis: str, digits: int) -> list[Write]:
        """Return what gives an axis an offset.

        Parameters
        ----------
        axis : str
            X, Y or Z.
        digits : int
            The offset, in steps of `step_um`.
        """

    def writes(self, offsets: Mapping[str, float]) -> list[Write]:
        """Return what gives the axes the offsets of an answer; nothing for those that stay.

        An offset that is not finite leaves the axis as it is, and one that is too far for one write
        is approached.

        Parameters
        ----------
        offsets : mapping of str to float
            dX, dY and dZ [um].
        """
        made: list[Write] = []
        for axis, signal, sign in zip(AXES, OFFSETS, self._signs, strict=True):
            wanted = sign * offsets.get(signal, 0.0)
            if not isfinite(wanted):
                continue
            before = self._digits[axis]
            digits = round(min(max(wanted, -self.most_um), self.most_um) / self.step_um)
            if isfinite(self.most_at_once_um):
                most = int(self.most_at_once_um / self.step_um)
                digits = min(max(digits, before - most), before + most)
            if digits != before:
                self._digits[axis] = digits
                made += self.write(axis, digits)
        return made
