"""How an axis of LinuxCNC comes to the offset that is wanted, and what it does meanwhile.

LinuxCNC takes an external offset as increments of a count, and takes them only while it is on,
homed and in a mode that moves axes; others are lost. So the loop is closed on the offset that it
says is in force (``eoffset-request``), and nothing is counted while it would not be taken, or while
what was counted last has not been looked at.

Switched off and on again, LinuxCNC sets its offset to zero and leaves the axis where it stands: the
offset is then *absorbed* by the commanded position. To give it again would move the axis twice as
far, and not to give it would lose it with the next move to an absolute position. So what was
absorbed counts as in force until the axis is commanded to move, and is given anew then.
"""

from __future__ import annotations

from dataclasses import dataclass

COUNT_UM = 0.01
"""What one count moves an axis by [um], given by the ``eoffset-scale`` of ``external.hal``."""
PATIENCE = 10
"""So many looks a control gets to take what it was given, before it counts as dropped: set on no
data."""


@dataclass(frozen=True)
class Seen:
    """What the control shows of an axis.

    Attributes
    ----------
    takes : bool
        It is on, homed, and in a mode in which offsets are taken.
    request_um : float
        The offset that it was given and holds [um].
    command_mm : float
        Where it is commanded to be, without the offset [mm].
    """

    takes: bool
    request_um: float
    command_mm: float


class AxisOffset:
    """One axis.

    Parameters
    ----------
    slew_um_s : float
        How fast its offset may change [um/s].
    request_um : float
        The offset that the control holds already [um].
    counts : int
        What it was given so far.

    Attributes
    ----------
    counts : int
        What to give.
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
        """Go towards the offset that is wanted.

        Parameters
        ----------
        wanted_um : float
            That offset [um].
        seen : Seen
            The axis now.
        elapsed_s : float
            Since the step before [s].
        """
        if not seen.takes:
            if self._taken:
                self._taken, self._before_um = False, seen.request_um
            self._asked = 0
            return
        if not self._taken:
            # What it held before and holds no more, it has absorbed.
            self._absorbed_um += self._before_um - seen.request_um
            self._stands_at, self._taken = seen.command_mm, True
        elif abs(seen.command_mm - self._stands_at) > COUNT_UM / 1e3:
            self._absorbed_um = 0.0
        self.in_force_um = seen.request_um + self._absorbed_um
        if self._asked and seen.request_um == self._held_um:
            # A busy computer: to ask again would move the axis twice as far.
            self._asked -= 1
            return
        most = self._slew * elapsed_s
        change = min(max(wanted_um - self.in_force_um, -most), most)
        count = round(change / COUNT_UM)
        self.counts += count
        self._asked, self._held_um = PATIENCE if count else 0, seen.request_um

    @property
    def at_zero(self) -> bool:
        """Whether the control holds no offset, and has absorbed none."""
        held = self.in_force_um - self._absorbed_um
        return max(abs(held), abs(self._absorbed_um)) < COUNT_UM
