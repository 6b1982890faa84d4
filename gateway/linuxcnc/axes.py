"""Brings an axis of LinuxCNC to the wanted offset.

LinuxCNC takes an external offset as increments of a count, and only while it is on, homed and in a
mode that moves axes; other increments are lost. So the loop is closed on the offset that it reports
as applied (``eoffset-request``), and nothing is counted while it would not be taken, or before the
last count has been taken.

When switched off and on again, LinuxCNC sets its offset to zero and leaves the axis where it
stands: the commanded position has then *absorbed* the offset. Giving it again would move the axis
twice as far; not giving it would lose it with the next move to an absolute position. So an absorbed
offset counts as in force until the axis is commanded to move, and is then given again.
"""

from __future__ import annotations

from dataclasses import dataclass

COUNT_UM = 0.01
"""How far one count moves an axis [um], given by the ``eoffset-scale`` of ``external.hal``."""
PATIENCE = 10
"""Number of steps in which a control must take what it was given, before that counts as dropped:
set on no data."""


@dataclass(frozen=True)
class Seen:
    """The control's report on an axis.

    Attributes
    ----------
    takes : bool
        Whether the control is on, homed and in a mode that takes offsets.
    request_um : float
        The offset that it was given and holds [um].
    command_mm : float
        The commanded position, without the offset [mm].
    """

    takes: bool
    request_um: float
    command_mm: float


class AxisOffset:
    """The offset of one axis.

    Parameters
    ----------
    slew_um_s : float
        How fast its offset may change [um/s].
    request_um : float
        The offset that the control already holds [um].
    counts : int
        The counts given to it so far.

    Attributes
    ----------
    counts : int
        The counts to give.
    in_force_um : float
        How far the axis is from where it would be without offsets [um].
    """

    def __init__(self, slew_um_s: float, request_um: float = 0.0, counts: int = 0) -> None:
        self._slew = slew_um_s
        self.counts, self.in_force_um = counts, request_um
        self._taken, self._before_um = True, request_um
        self._absorbed_um, self._stands_at = 0.0, 0.0
        self._asked, self._held_um = 0, request_um

    def step(self, wanted_um: float, seen: Seen, elapsed_s: float) -> None:
        """Move towards the wanted offset.

        Parameters
        ----------
        wanted_um : float
            The wanted offset [um].
        seen : Seen
            The axis now.
        elapsed_s : float
            Time since the last step [s].
        """
        if not seen.takes:
            if self._taken:
                self._taken, self._before_um = False, seen.request_um
            self._asked = 0
            return
        if not self._taken:
            # It has absorbed what it held before and no longer holds.
            self._absorbed_um += self._before_um - seen.request_um
            self._stands_at, self._taken = seen.command_mm, True
        elif abs(seen.command_mm - self._stands_at) > COUNT_UM / 1e3:
            self._absorbed_um = 0.0
        self.in_force_um = seen.request_um + self._absorbed_um
        if self._asked and seen.request_um == self._held_um:
            # The computer is busy: asking again would move the axis twice as far.
            self._asked -= 1
            return
        most = self._slew * elapsed_s
        change = min(max(wanted_um - self.in_force_um, -most), most)
        count = round(change / COUNT_UM)
        self.counts += count
        self._asked, self._held_um = PATIENCE if count else 0, seen.request_um

    @property
    def at_zero(self) -> bool:
        """Whether the control holds no offset and has absorbed none."""
        held = self.in_force_um - self._absorbed_um
        return max(abs(held), abs(self._absorbed_um)) < COUNT_UM
