"""How a control uses the offsets that it receives, and what it does without any."""

from __future__ import annotations

from math import isfinite

from gateway.database import OFFSETS
from gateway.reception import Cycle

NONE_YET, FOLLOWING, HOLDING, RETURNING = "none_yet", "following", "holding", "returning_to_zero"


class OffsetFollower:
    """The offsets that a control wants to apply; its axes move there at their own pace.

    Invalid offsets are followed too: the gateway holds or ramps them, and a control that dropped
    them would make the step that the gateway avoids. If no offsets come, because the gateway is
    silent, its frames are faulty or it has none to give, the last ones are held, then given up.

    Parameters
    ----------
    hold_s : float
        How long offsets are held, in the machine's time [s].

    Attributes
    ----------
    use : str
        As the DBC names the values of ``offset_use``.
    wanted : dict of str to float
        The offsets [um].
    """

    def __init__(self, hold_s: float) -> None:
        self._hold_s = hold_s
        self._held_s = 0.0
        self.use = NONE_YET
        self.wanted = dict.fromkeys(OFFSETS, 0.0)

    def follow(self, cycle: Cycle | None, step_s: float) -> dict[str, float]:
        """Return the offsets for the next step.

        Parameters
        ----------
        cycle : Cycle or None
            The gateway's newest answer; None if none came since the last step.
        step_s : float
            How long that step took, in the machine's time [s].
        """
        offsets = {name: cycle.values.get(name, 0.0) for name in OFFSETS} if cycle else {}
        if cycle and cycle.usable and all(isfinite(value) for value in offsets.values()):
            self.wanted, self.use, self._held_s = offsets, FOLLOWING, 0.0
        elif self.use != NONE_YET:
            self._held_s += step_s
            self.use = HOLDING if self._held_s <= self._hold_s else RETURNING
            if self.use == RETURNING:
                self.wanted = dict.fromkeys(OFFSETS, 0.0)
        return self.wanted
